#!/usr/bin/env bash
# One would guess that a message-compressed bag in MCAP storage is either readable by the mcap package or marked in the file.
# The file says encoding cdr and nothing of zstd: mcap hands out 27 compressed bytes for a message of 1009, without an error;
# only metadata.yaml beside it tells. STORAGE compression is read by both. rosbags 0.11.9, mcap 1.6.0, 2026-11-29.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check rosbags==0.11.9 mcap==1.6.0 zstandard==0.25.0

env/bin/python - <<'EOF'
from importlib.metadata import version
from pathlib import Path

from mcap.reader import make_reader
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

print("rosbags", version("rosbags"), "mcap", version("mcap"))
store, name = get_typestore(Stores.ROS2_HUMBLE), "std_msgs/msg/String"
raw = bytes(store.serialize_cdr(store.types[name]("x" * 1000), name))
for mode in (CompressionMode.STORAGE, CompressionMode.MESSAGE):
    bag = Path(mode.name.lower())
    writer = Writer(bag, version=9, storage_plugin=StoragePlugin.MCAP)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    writer.open()
    writer.write(writer.add_connection("/a", name, typestore=store), 1, raw)
    writer.close()
    with Reader(bag) as reader:
        own = [bytes(data) for _, _, data in reader.messages()]
    (file,) = bag.glob("*.mcap")
    with file.open("rb") as stream:
        schema, channel, message = next(make_reader(stream).iter_messages())
    print(f"{mode.name}: rosbags reads {len(own[0])} bytes, mcap {len(message.data)} of encoding {channel.message_encoding}, "
          f"channel metadata {channel.metadata}")
    assert own == [raw] and channel.message_encoding == "cdr" and "zstd" not in str(channel.metadata)
    assert (message.data == raw) == (mode is CompressionMode.STORAGE)
assert message.data[:4] == bytes.fromhex("28b52ffd"), "the magic number of zstd"
assert "zstd" in (bag / "metadata.yaml").read_text()
EOF
