#!/usr/bin/env bash
# One would guess that a converter from MCAP to LeRobot takes a CompressedImage topic as it takes a raw one, and leaves out, or names,
# a topic that it cannot use. Forge converts raw RGB images; compressed ones end with "Camera dimensions must be positive", and a depth
# image (32FC1) beside good RGB ones ends the whole conversion with "cannot reshape". forge-robotics 0.2.0, 2026-11-30.

set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv env
env/bin/pip install --quiet --disable-pip-version-check forge-robotics==0.2.0 rosbags==0.11.9 mcap==1.6.0 mcap-ros2-support==0.6.0 \
    numpy==2.4.6 opencv-python-headless==5.0.0.93 av==18.1.0 pyarrow==26.0.1

env/bin/python - <<'EOF'
import subprocess
from importlib.metadata import version
from pathlib import Path

import cv2
import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

print("forge-robotics", version("forge-robotics"))
store = get_typestore(Stores.ROS2_HUMBLE)
Time, Header, Image, Packed, Layout, Action = (store.types[kind] for kind in (
    "builtin_interfaces/msg/Time", "std_msgs/msg/Header", "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage",
    "std_msgs/msg/MultiArrayLayout", "std_msgs/msg/Float64MultiArray"))
colours = np.random.default_rng(0).integers(0, 256, (64, 64, 3), np.uint8)


def frame(kind, at):
    header = Header(Time(at, 0), "camera")
    if kind == "depth":
        return Image(header, 64, 64, "32FC1", 0, 256, np.ones((64, 64), np.float32).view(np.uint8).reshape(-1))
    if kind == "rgb":
        return Image(header, 64, 64, "rgb8", 0, 192, colours.reshape(-1))
    return Packed(header, kind, cv2.imencode(f".{kind}", colours)[1].reshape(-1))


def converted(*kinds):
    """What forge says of a bag with these image topics and an action."""
    name = "_".join(kinds)
    writer = Writer(Path(name), version=8, storage_plugin=StoragePlugin.MCAP)
    writer.open()
    topics = {f"/{kind}/image_raw": kind for kind in kinds}
    connections = {topic: writer.add_connection(topic, frame(kind, 0).__msgtype__, typestore=store) for topic, kind in topics.items()}
    action = writer.add_connection("/action", Action.__msgtype__, typestore=store)
    for at in range(1, 11):
        for topic, kind in topics.items():
            message = frame(kind, at)
            writer.write(connections[topic], at * 10**8, store.serialize_cdr(message, message.__msgtype__))
        writer.write(action, at * 10**8, store.serialize_cdr(Action(Layout([], 0), np.ones(1)), Action.__msgtype__))
    writer.close()
    ended = subprocess.run(["env/bin/forge", "convert", f"{name}/{name}.mcap", f"out_{name}", "--format", "lerobot-v3"],
                           capture_output=True, text=True)
    said = " ".join((ended.stdout + ended.stderr).split())
    print(f"{name}: ... {said[said.find('Source format'):][:260]}")
    return said


assert "Conversion successful" in converted("rgb") and Path("out_rgb/meta/info.json").is_file()
for kind in ("png", "jpg"):
    assert "Camera dimensions must be positive" in converted(kind)
assert "cannot reshape array of size 16384" in converted("rgb", "depth")
EOF
