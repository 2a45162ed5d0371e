#!/usr/bin/env bash
# One would guess that leaving `with Writer(...)` by an exception closes the bag, so that what was written until then can be read.
# It is thrown away: the folder stays, without metadata.yaml and without one message, in SQLite and in MCAP storage alike,
# though 1000 messages were written. Calling close() oneself keeps them. rosbags 0.11.9, 2026-11-29.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check rosbags==0.11.9

env/bin/python - <<'EOF'
from importlib.metadata import version
from pathlib import Path

from rosbags.rosbag2 import Reader, ReaderError, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

store, name = get_typestore(Stores.ROS2_HUMBLE), "std_msgs/msg/String"
raw = store.serialize_cdr(store.types[name]("x" * 100), name)


def write(writer):
    connection = writer.add_connection("/a", name, typestore=store)
    for time in range(1000):
        writer.write(connection, time, raw)
    raise RuntimeError("the robot's program stops here")


def found(path):
    try:
        with Reader(path) as reader:
            return len(list(reader.messages()))
    except (ReaderError, FileNotFoundError) as error:
        return f"{type(error).__name__}: {str(error).split(chr(39))[0].strip()}"


print("rosbags", version("rosbags"))
for plugin in StoragePlugin:
    bag = Path(f"with_{plugin.name}")
    try:
        with Writer(bag, version=9, storage_plugin=plugin) as writer:
            write(writer)
    except RuntimeError:
        pass
    left = sorted(bag.iterdir())
    print(f"{plugin.name}, with:", [(path.name, path.stat().st_size) for path in left])
    for path in (bag, *left):
        print("  read", path.name, "->", found(path))
        assert found(path) in (0, "FileNotFoundError: Expected metadata file", "ReaderError: File end magic is invalid.")
    kept = Path(f"close_{plugin.name}")
    writer = Writer(kept, version=9, storage_plugin=plugin)
    writer.open()
    try:
        write(writer)
    except RuntimeError:
        writer.close()
    print(f"{plugin.name}, close():", found(kept), "messages")
    assert found(kept) == 1000
EOF
