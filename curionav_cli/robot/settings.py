"""Settings of the robot; conf/robot/turtlebot2i.yaml gives the source of each value."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from curionav_cli.bounds import bounded
from curionav_cli.robot.docking_settings import Docking


@dataclass(frozen=True)
class Robot:
    """robot=ideal: perfect motion, put back to the start after each episode. The base of the other robots."""

    name: str


class Localisation(Enum):
    """What the LiDAR adds to odometry and gyro: nothing, scan-to-scan motion (whose errors still add up), or the pose
    on the robot's own map."""

    none = "none"
    scan_odometry = "scan_odometry"
    scan_to_map = "scan_to_map"


@dataclass(frozen=True)
class Battery:
    """Seconds of driving. An episode ends when no more than `reserve` is left, for the return to dock."""

    capacity: float
    reserve: float

    def __post_init__(self) -> None:
        bounded("robot.battery", self, {"reserve": (0, 10**6), "capacity": (self.reserve, 10**6)})


@dataclass(frozen=True)
class Drive:
    """How motion falls short of the command: standard deviations, normal and independent from move to move.

    forward: of the distance, m / sqrt(m). veer: of the heading, degrees / sqrt(m) driven. turn: degrees / sqrt(turn of
    1 rad). On contact the wheels go on for slip_least to slip_most of what was left, and the base twists (degrees).
    """

    forward: float
    veer: float
    turn: float
    slip_least: float
    slip_most: float
    twist: float

    def __post_init__(self) -> None:
        bounded("robot.drive", self, {
            "forward slip_most": (0, 1), "veer turn twist": (0, 360), "slip_least": (0, self.slip_most)})


@dataclass(frozen=True)
class Odometry:
    """Wheel encoders. scale: sd of the error of scale, drawn for each episode. noise: sd, m / sqrt(m)."""

    scale: float
    noise: float

    def __post_init__(self) -> None:
        bounded("robot.odometry", self, {"scale noise": (0, 1)})


@dataclass(frozen=True)
class Gyro:
    """A gyro. scale: sd of the error of scale, drawn for each episode. noise: sd, degrees / sqrt(s).

    bias: sd of the bias that is left after resting on the dock, degrees / s. walk: sd of its random walk from there,
    degrees / s / sqrt(s).
    """

    scale: float
    noise: float
    bias: float
    walk: float

    def __post_init__(self) -> None:
        bounded("robot.gyro", self, {"scale": (0, 1), "noise bias walk": (0, 360)})


@dataclass(frozen=True)
class Rays:
    """A range sensor: `beams` evenly over `view` degrees; no answer beyond `far` or nearer than `blind` metres.
    noise: sd of a range, metres."""

    beams: int
    view: float
    blind: float
    far: float
    noise: float


@dataclass(frozen=True)
class ScanOdometry:
    """Motion from scan to scan. position (m) and yaw (degrees): sd of each, where the walls face all ways alike.
    narrowest: the least share of walls facing a direction with which motion along it is observed."""

    position: float
    yaw: float
    narrowest: float

    def __post_init__(self) -> None:
        bounded("robot.scan_odometry", self, {"position": (1e-4, 1), "yaw": (1e-3, 360), "narrowest": (1e-6, 0.5)})


@dataclass(frozen=True)
class ScanToMap:
    """Scan matching on the robot's own map. noise (m): sd of a return off its wall; position (m) and yaw (degrees): sd
    of the error of the map itself, a lower bound for any number of returns."""

    noise: float
    position: float
    yaw: float

    def __post_init__(self) -> None:
        bounded("robot.scan_to_map", self, {"noise position": (1e-4, 1), "yaw": (1e-3, 360)})


@dataclass(frozen=True)
class Filter:
    """The filter. dock_position (m), dock_yaw (degrees): sd of the true start of an episode, and of its prior there.

    gate: the share of good measurements that the filter accepts. patience: rejections in a row after which the
    localiser is lost; lost_position (m), lost_yaw (degrees): sd that is added to the pose then.
    """

    dock_position: float
    dock_yaw: float
    gate: float
    patience: int
    lost_position: float
    lost_yaw: float

    def __post_init__(self) -> None:
        bounded("robot.filter", self, {
            "dock_position": (1e-4, 10), "dock_yaw": (1e-2, 360), "gate": (0.5, 1 - 1e-9), "patience": (1, 10**6),
            "lost_position": (0, 10), "lost_yaw": (0, 360)})


@dataclass(frozen=True)
class Turtlebot(Robot):
    """A Kobuki base with wheel encoders, a gyro, a LiDAR and a depth camera. step: seconds of one action."""

    step: float
    localisation: Localisation
    battery: Battery
    drive: Drive
    odometry: Odometry
    gyro: Gyro
    lidar: Rays
    depth: Rays
    scan_odometry: ScanOdometry
    scan_to_map: ScanToMap
    filter: Filter
    docking: Docking

    @property
    def steps(self) -> int:
        """The most actions of an episode before the battery's reserve is reached."""
        return max(1, math.ceil(round((self.battery.capacity - self.battery.reserve) / self.step, 6)))

    def __post_init__(self) -> None:
        bounded("robot", self, {"step": (0.01, 60)})
        for name, rays in (("lidar", self.lidar), ("depth", self.depth)):
            bounded(f"robot.{name}", rays, {
                "beams": (2, 10**4), "view": (1, 360), "far": (0, 1000), "blind": (0, rays.far), "noise": (0, 10)})
