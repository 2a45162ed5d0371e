#!/usr/bin/env bash
# One would guess that an MCAP file holds checksums by which a flipped bit is found, and that mcap's validate_crcs=True compares them.
# rosbags writes 0 for each of them, which means "none", and zstd frames without a checksum: of 114 single flipped bits in a
# message of 20 000 letters all pass through mcap and rosbags in the plain bag, and 113 in the compressed one; mcap's own writer: 0.
# rosbags 0.11.9, mcap 1.6.0, 2026-11-30.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check rosbags==0.11.9 mcap==1.6.0 zstandard==0.25.0

env/bin/python - <<'EOF'
import random
from importlib.metadata import version
from pathlib import Path

from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

print("rosbags", version("rosbags"), "mcap", version("mcap"))
store, name = get_typestore(Stores.ROS2_HUMBLE), "std_msgs/msg/String"
text = "".join(random.Random(0).choices("abcdefghijklmnopqrstuvwxyz", k=20_000))
sent = bytes(store.serialize_cdr(store.types[name](text), name))


def by_mcap(path):
    with path.open("rb") as file:
        return [message.data for _, _, message in make_reader(file, validate_crcs=True).iter_messages()]


def by_rosbags(path):
    with Reader(path) as reader:
        return [bytes(data) for _, _, data in reader.messages()]


def unnoticed(path, read):
    """How many of 114 flipped bits give another message without an error."""
    whole, other, count = path.read_bytes(), path.with_name("flipped.mcap"), 0
    for place in range(600, 12_000, 100):
        flipped = bytearray(whole)
        flipped[place] ^= 1
        other.write_bytes(flipped)
        try:
            count += read(other) != [sent]
        except Exception:
            pass
    return count


found = {}
for mode in (CompressionMode.NONE, CompressionMode.STORAGE):
    writer = Writer(Path(mode.name), version=9, storage_plugin=StoragePlugin.MCAP)
    if mode is CompressionMode.STORAGE:
        writer.set_compression(mode, CompressionFormat.ZSTD)
    writer.open()
    writer.write(writer.add_connection("/a", name, typestore=store), 1, sent)
    writer.close()
    path = Path(mode.name, f"{mode.name}.mcap")
    found[mode.name] = unnoticed(path, by_mcap), unnoticed(path, by_rosbags)
with open("own.mcap", "wb") as file:
    writer = McapWriter(file, compression=CompressionType.NONE)
    writer.start("ros2", "test")
    channel = writer.register_channel("/a", "cdr", writer.register_schema(name, "ros2msg", b"string data"))
    writer.add_message(channel, log_time=1, publish_time=1, data=sent)
    writer.finish()
found["mcap's writer"] = unnoticed(Path("own.mcap"), by_mcap), None
for what, (mcap, rosbags) in found.items():
    print(f"{what}: of 114 flipped bits mcap passes on {mcap}, rosbags {rosbags}")
assert found["NONE"] == (114, 114) and min(found["STORAGE"]) >= 100 and found["mcap's writer"][0] == 0
EOF
