"""Messages of ROS 1 and 2 as rosbridge writes them in JSON, and what they say. Errors are MessageFaults of one line.

Numbers that JSON has no word for (nan, inf) arrive as null; bytes as base64. A time is {sec, nanosec} in ROS 2 and
{secs, nsecs} in ROS 1.
"""

from __future__ import annotations

import base64
import binascii
import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

import numpy as np

from curionav_cli.live.safety import MessageFault
from curionav_cli.live.transport import Message
from curionav_cli.robot.measurements import Scan


class Odometry(NamedTuple):
    """x, y (m) and yaw (rad) in the odometry's own frame; speed (m/s), rate (rad/s); stamp: seconds, robot's clock."""

    x: float
    y: float
    yaw: float
    speed: float
    rate: float
    stamp: float


@contextmanager
def expected(kind: str) -> Iterator[None]:
    """Turn errors of taking a message apart into a MessageFault that names its type."""
    try:
        yield
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError, binascii.Error) as error:
        raise MessageFault(f"a message that is no {kind} ({type(error).__name__}: {error})") from error


def stamp_of(message: Message) -> float:
    """The time in a message's header, seconds on the robot's clock."""
    with expected("message with a header"):
        stamp = message["header"]["stamp"]
        whole, part = ("sec", "nanosec") if "sec" in stamp else ("secs", "nsecs")
        return float(stamp[whole]) + 1e-9 * float(stamp[part])


def stamp(seconds: float, ros: int) -> Message:
    """A header with this time."""
    whole, part = int(seconds), int(1e9 * (seconds % 1.0))
    time = {"sec": whole, "nanosec": part} if ros == 2 else {"secs": whole, "nsecs": part}
    return {"stamp": time, "frame_id": ""}


def odometry(message: Message) -> Odometry:
    """What a nav_msgs/Odometry says of motion in the plane."""
    with expected("nav_msgs/Odometry"):
        place, moving = message["pose"]["pose"], message["twist"]["twist"]
        x, y = float(place["position"]["x"]), float(place["position"]["y"])
        found = Odometry(x, y, yaw_of(place["orientation"]), float(moving["linear"]["x"]),
                         float(moving["angular"]["z"]), stamp_of(message))
    if not all(map(math.isfinite, found)):
        raise MessageFault("odometry that is not finite")
    return found


def yaw_of(quaternion: Message) -> float:
    """The yaw of an orientation, radians."""
    x, y, z, w = (float(quaternion[key]) for key in "xyzw")
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def yaw_rate(message: Message) -> float:
    """The rate about the vertical axis of a sensor_msgs/Imu, rad/s to the left."""
    with expected("sensor_msgs/Imu"):
        return float(message["angular_velocity"]["z"])


def laser(message: Message, turned: float) -> Scan:
    """A sensor_msgs/LaserScan as a Scan. turned: radians to the left by which the scanner looks away from ahead."""
    with expected("sensor_msgs/LaserScan"):
        ranges = np.array(message["ranges"], np.float64)
        least, most = float(message["range_min"]), float(message["range_max"])
        bearing = float(message["angle_min"]) + float(message["angle_increment"]) * np.arange(len(ranges)) + turned
        ranges[~((ranges >= least) & (ranges <= most))] = np.nan
    return Scan((bearing + math.pi) % (2.0 * math.pi) - math.pi, ranges, stamp_of(message))


def raw_bytes(data: object) -> bytes:
    """The bytes of a message's data: base64, bytes, or a list of numbers."""
    if isinstance(data, str):
        return base64.b64decode(data, validate=True)
    if isinstance(data, list):
        return bytes(data)
    if isinstance(data, bytes | bytearray):
        return bytes(data)
    raise TypeError(f"data is a {type(data).__name__}")


def twist(speed: float, rate: float, stamped: bool, seconds: float, ros: int) -> Message:
    """A velocity command, with a header or without. speed: m/s; rate: rad/s to the left."""
    plain = {"linear": {"x": speed, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": rate}}
    return {"header": stamp(seconds, ros), "twist": plain} if stamped else plain


def command(message: Message) -> tuple[float, float]:
    """The speed (m/s) and rate (rad/s to the left) of a velocity command, with a header or without."""
    with expected("geometry_msgs/Twist or TwistStamped"):
        plain = message.get("twist", message)
        found = float(plain["linear"]["x"]), float(plain["angular"]["z"])
    if not all(map(math.isfinite, found)):
        raise MessageFault("a velocity that is not finite")
    return found
