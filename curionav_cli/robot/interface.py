"""What navigation and docking need of a robot: motors, sensors, battery. Nothing here gives the true pose.

`robot_base.RobotBase` implements it in simulation; a driver of real hardware would implement the same.
"""

from __future__ import annotations

from typing import Protocol

from curionav_cli.records import Pose
from curionav_cli.robot.measurements import Reading, Scan, Signals


class Battery(Protocol):
    """A battery. left, capacity: seconds of driving."""

    left: float
    capacity: float

    @property
    def empty(self) -> bool:
        """True when the robot can drive no more."""


class Estimate(Protocol):
    """The estimate of a robot's pose."""

    @property
    def pose(self) -> Pose:
        """The estimated pose."""

    def update(self, reading: Reading, scan: Scan | None = None) -> None:
        """Take what was measured over a motion."""


class Docker(Protocol):
    """What docking needs of a differential-drive base."""

    @property
    def hazard(self) -> str | None:
        """What is wrong under the wheels: "wheel_drop", "cliff" or None."""

    @property
    def battery(self) -> Battery:
        """The robot's battery."""

    @property
    def silent(self) -> set[str]:
        """The names of sensors that send nothing."""

    @property
    def charging(self) -> bool:
        """True while current flows through the charging contacts."""

    def drive(self, distance: float, turn: float, seconds: float) -> Reading:
        """Drive a short arc of `distance` metres and `turn` radians to the left in `seconds`."""

    def halt(self) -> None:
        """Set the velocity to zero."""

    def signals(self) -> Signals:
        """Read the next frame of the infrared receivers."""


class Base(Docker, Protocol):
    """A differential-drive base with its sensors."""

    @property
    def velocity(self) -> tuple[float, float]:
        """The last command: m/s, and rad/s to the left."""

    def scan(self) -> Scan:
        """Take a LiDAR scan, all around."""

    def depth(self) -> Scan:
        """Take the horizontal line of the depth camera, ahead."""
