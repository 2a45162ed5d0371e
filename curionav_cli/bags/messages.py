"""ROS 2 messages, as rosbags writes them. Times are nanoseconds; frames: map, odom, base_link, camera."""

from __future__ import annotations

import math
from typing import Any

import cv2
import numpy as np
from rosbags.typesys import Stores, get_typestore

from curionav_cli.records import Pose

STORE = get_typestore(Stores.ROS2_HUMBLE)
OPTICAL = (-0.5, 0.5, -0.5, 0.5)  # quaternion of a camera that looks ahead: its z ahead, x right, y down
NO_COVARIANCE = np.zeros(36)


def new(kind: str, *fields: Any) -> Any:
    """A message of a type, such as geometry_msgs/Point, of its fields in order."""
    package, _, name = kind.partition("/")
    return STORE.types[f"{package}/msg/{name}"](*fields)


def serialised(message: Any) -> bytes:
    """The message's CDR bytes."""
    return bytes(STORE.serialize_cdr(message, message.__msgtype__))


def header(at: int, frame: str) -> Any:
    return new("std_msgs/Header", new("builtin_interfaces/Time", at // 10**9, at % 10**9), frame)


def quaternion(yaw: float) -> Any:
    return new("geometry_msgs/Quaternion", 0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))


def vector(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
    return new("geometry_msgs/Vector3", float(x), float(y), float(z))


def pose(at: Pose) -> Any:
    return new("geometry_msgs/Pose", new("geometry_msgs/Point", float(at.x), float(at.y), 0.0), quaternion(at.yaw))


def png(image: np.ndarray, at: int) -> Any:
    """A CompressedImage of an RGB image (H, W, 3) uint8, without loss."""
    whole, data = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
    assert whole
    return new("sensor_msgs/CompressedImage", header(at, "camera"), "png", data.reshape(-1))


def raw(image: np.ndarray, at: int) -> Any:
    """An Image of an RGB image (H, W, 3) uint8, or of depth (H, W) float32 in metres."""
    height, width = image.shape[:2]
    encoding = "rgb8" if image.ndim == 3 else "32FC1"
    data = np.ascontiguousarray(image).view(np.uint8).reshape(-1)
    return new("sensor_msgs/Image", header(at, "camera"), height, width, encoding, 0, len(data) // height, data)


def odometry(here: Pose, speed: float, rate: float, at: int) -> Any:
    """Odometry. speed: m/s ahead; rate: rad/s to the left."""
    return new("nav_msgs/Odometry", header(at, "odom"), "base_link",
               new("geometry_msgs/PoseWithCovariance", pose(here), NO_COVARIANCE),
               new("geometry_msgs/TwistWithCovariance", new("geometry_msgs/Twist", vector(speed), vector(z=rate)),
                   NO_COVARIANCE))


def planar(parent: str, child: str, at: Pose, time: int) -> Any:
    """The transform of a frame that stands in its parent at a pose."""
    return new("geometry_msgs/TransformStamped", header(time, parent), child,
               new("geometry_msgs/Transform", vector(at.x, at.y), quaternion(at.yaw)))


def camera(height: float, time: int) -> Any:
    """The transform of the camera, which looks ahead from `height` metres above base_link."""
    return new("geometry_msgs/TransformStamped", header(time, "base_link"), "camera",
               new("geometry_msgs/Transform", vector(z=height), new("geometry_msgs/Quaternion", *OPTICAL)))


def transforms(*found: Any) -> Any:
    return new("tf2_msgs/TFMessage", list(found))


def grid(cells: np.ndarray, cell: float, corner: Pose, frame: str, at: int) -> Any:
    """An OccupancyGrid of cells (rows, columns) int8, -1 unknown, 0 free to 100 occupied, row 0 the lowest."""
    rows, columns = cells.shape
    info = new("nav_msgs/MapMetaData", new("builtin_interfaces/Time", at // 10**9, at % 10**9), cell, columns, rows,
               pose(corner))
    return new("nav_msgs/OccupancyGrid", header(at, frame), info, cells.astype(np.int8).reshape(-1))


def numbers(label: str, *values: float) -> Any:
    """A Float64MultiArray; label: what its numbers are."""
    found = np.array(values, np.float64)
    layout = new("std_msgs/MultiArrayLayout", [new("std_msgs/MultiArrayDimension", label, len(found), len(found))], 0)
    return new("std_msgs/Float64MultiArray", layout, found)


def text(words: str) -> Any:
    return new("std_msgs/String", words)
