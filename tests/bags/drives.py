"""Bags of a robot that drives continuously, as other recorders write them; every image tells when it was taken."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rosbags.rosbag1 import Writer as Ros1
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

IMAGE, ODOM = "/camera/image_raw/compressed", "/odom"  # of turtlebot3
STARTED = 1000.0  # seconds on the robot's clock

Leg = tuple[float, float, float]  # seconds, m/s, rad/s


@dataclass
class Drive:
    """What a robot sends while it drives legs. odometry, images: times a second; depth: the topic of its depth images,
    if it has any, all of whose pixels are 1 m and 0.1 m more a second; change: alters each message, by topic, number
    and fields, or leaves it out by returning None."""

    legs: Sequence[Leg]
    odometry: float = 50.0
    images: float = 25.0
    side: int = 96
    raw: bool = False
    encoding: str = "rgb8"
    image: str = IMAGE
    odom: str = ODOM
    depth: str = ""
    change: Callable[[str, int, dict[str, Any]], dict[str, Any] | None] = lambda topic, number, fields: fields
    sent: list[tuple[float, str, dict[str, Any]]] = field(default_factory=list)

    def __post_init__(self) -> None:
        seconds = sum(leg[0] for leg in self.legs)
        for topic, rate in ((self.odom, self.odometry), (self.depth, 10.0), (self.image, self.images)):
            for number in range(int(seconds * rate) + 1 if topic else 0):
                at = number / rate
                made = self.pose(at) if topic == self.odom else self.view(at)
                fields = self.change(topic, number, {"stamp": STARTED + at, **made})
                if fields is not None:
                    self.sent.append((STARTED + at, topic, fields))
        self.sent.sort(key=lambda one: one[0])

    def pose(self, at: float) -> dict[str, Any]:
        """x, y, yaw after `at` seconds: straight lines and arcs."""
        x = y = yaw = 0.0
        for seconds, speed, rate in self.legs:
            part = max(0.0, min(seconds, at))
            way, half = speed * part, 0.5 * rate * part
            chord = way * (math.sin(half) / half if half else 1.0)
            x, y = x + chord * math.cos(yaw + half), y + chord * math.sin(yaw + half)
            yaw, at = yaw + 2.0 * half, at - part
        return {"x": x, "y": y, "yaw": yaw}

    def view(self, at: float) -> dict[str, Any]:
        """An image whose colour is the number of centiseconds."""
        tick = round(at * 100)
        return {"colour": (tick % 256, tick // 256, 7), "side": self.side, "encoding": self.encoding}


def taken(image: np.ndarray) -> float:
    """When an image of `Drive.view` was taken, seconds after the start."""
    return (int(image[0, 0, 0]) + 256 * int(image[0, 0, 1])) / 100


def message(store: Any, ros: int, topic: str, fields: dict[str, Any], drive: Drive) -> Any:
    """The message of `fields`."""
    new = lambda kind, *values: store.types[kind](*values)
    whole = int(fields["stamp"])
    stamp = new("builtin_interfaces/msg/Time", whole, round(1e9 * (fields["stamp"] - whole)))
    header = new("std_msgs/msg/Header", *([0] if ros == 1 else []), stamp, "frame")
    vector = new("geometry_msgs/msg/Vector3", 0.0, 0.0, 0.0)
    if topic == drive.odom:
        yaw = fields["yaw"]
        turned = new("geometry_msgs/msg/Quaternion", 0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        pose = new("geometry_msgs/msg/Pose", new("geometry_msgs/msg/Point", fields["x"], fields["y"], 0.0), turned)
        moving = new("geometry_msgs/msg/Twist", vector, vector)
        return new("nav_msgs/msg/Odometry", header, "base",
                   new("geometry_msgs/msg/PoseWithCovariance", pose, np.zeros(36)),
                   new("geometry_msgs/msg/TwistWithCovariance", moving, np.zeros(36)))
    side = fields["side"]
    if topic == drive.depth:
        metres = np.full((side, side), 1.0 + 0.1 * (fields["stamp"] - STARTED), np.float32)
        return new("sensor_msgs/msg/Image", header, side, side, "32FC1", 0, 4 * side, metres.view(np.uint8).reshape(-1))
    colours = np.full((side, side, 3), fields["colour"], np.uint8)
    if drive.raw:
        return new("sensor_msgs/msg/Image", header, side, side, fields["encoding"], 0, 3 * side, colours.reshape(-1))
    data = fields.get("data", cv2.imencode(".png", colours[..., ::-1])[1].reshape(-1))
    return new("sensor_msgs/msg/CompressedImage", header, "png", data)


def ros2(folder: Path, drive: Drive, plugin: StoragePlugin = StoragePlugin.MCAP) -> Path:
    """Write a ROS 2 bag; returns its folder."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    writer = Writer(folder, version=8, storage_plugin=plugin)
    writer.open()
    topics: dict[str, Any] = {}
    for at, topic, fields in drive.sent:
        one = message(store, 2, topic, fields, drive)
        if topic not in topics:
            topics[topic] = writer.add_connection(topic, one.__msgtype__, typestore=store)
        writer.write(topics[topic], round(1e9 * at), store.serialize_cdr(one, one.__msgtype__))
    writer.close()
    return folder


def mcap(folder: Path, drive: Drive) -> Path:
    """Write a ROS 2 bag; returns its MCAP file."""
    return ros2(folder, drive) / f"{folder.name}.mcap"


def ros1(path: Path, drive: Drive) -> Path:
    """Write a ROS 1 bag; returns its file."""
    store = get_typestore(Stores.ROS1_NOETIC)
    topics: dict[str, Any] = {}
    with Ros1(path) as writer:
        for at, topic, fields in drive.sent:
            one = message(store, 1, topic, fields, drive)
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, one.__msgtype__, typestore=store)
            writer.write(topics[topic], round(1e9 * at), store.serialize_ros1(one, one.__msgtype__))
    return path
