"""Wheel encoders, gyro, LiDAR, depth camera, scan matching: what is true in, what the robot gets out."""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.collision_world import CollisionWorld
from curionav_cli.robot.measurements import Scan, Shift
from curionav_cli.robot.settings import Gyro, Odometry, Rays, ScanOdometry

UNSEEN = 1.0  # metres; sd of a motion that the scans cannot tell
GAP, SPAN = 0.5, 4


class Inertia:
    """Encoders and gyro. Their errors of scale are drawn anew by `rest`, and the gyro's bias wanders."""

    def __init__(self, odometry: Odometry, gyro: Gyro, generator: np.random.Generator):
        self.odometry, self.gyro, self.rng = odometry, gyro, generator
        self.rest()

    def rest(self) -> None:
        """On the dock the gyro's bias is measured, all but a remainder; another episode, another load and floor."""
        scale, turn, bias = self.rng.standard_normal(3).tolist()
        self.scale, self.turn_scale = scale * self.odometry.scale, turn * self.gyro.scale
        self.bias = math.radians(bias * self.gyro.bias)  # rad / s

    def measure(self, rolled: float, turned: float, seconds: float) -> tuple[float, float]:
        """(wheel, gyro) in metres and radians, of a move that rolled and turned so much."""
        wheel, gyro, walk = self.rng.standard_normal(3).tolist()
        root = math.sqrt(seconds)
        rate = turned * (1.0 + self.turn_scale) + self.bias * seconds + math.radians(gyro * self.gyro.noise) * root
        self.bias += math.radians(walk * self.gyro.walk) * root
        return rolled * (1.0 + self.scale) + wheel * self.odometry.noise * math.sqrt(abs(rolled)), rate


class Ranger:
    """A fan of rays from the robot's centre."""

    def __init__(self, settings: Rays, generator: np.random.Generator):
        self.settings, self.rng = settings, generator
        half = math.radians(settings.view) / 2.0
        step = 2.0 * half / (settings.beams if settings.view == 360 else settings.beams - 1)
        self.bearing = -half + step * np.arange(settings.beams)

    def scan(self, pose: Pose, around: CollisionWorld, time: float) -> Scan:
        """Ranges from a pose; nothing is seen that is nearer than `blind` metres, nor through it."""
        angle = pose.yaw + self.bearing
        found = around.ranges(pose.x, pose.y, np.cos(angle), np.sin(angle), self.settings.far)
        unseen = (found < self.settings.blind) | ~np.isfinite(found)
        found += self.settings.noise * self.rng.standard_normal(len(found))
        found[unseen] = np.nan
        return Scan(self.bearing, found, time)


class ScanMatch:
    """What matching a scan to the one before tells of the motion between: the truth, and an error drawn from the
    covariance that it states. Along walls that all face one way it can tell nothing, and states that."""

    def __init__(self, settings: ScanOdometry, generator: np.random.Generator):
        self.settings, self.rng = settings, generator
        self.before: Pose | None = None

    def forget(self) -> None:
        """There is no scan before."""
        self.before = None

    def shift(self, scan: Scan, pose: Pose) -> Shift | None:
        """The motion since the last scan, to this one's pose; None for the first, or a silent one."""
        before, self.before = self.before, pose
        share, axes = facing(scan)
        error = self.rng.standard_normal(3)
        if before is None or not share.any():
            self.before = pose if share.any() else None
            return None
        told = self.settings.position / np.sqrt(2.0 * np.maximum(share, 1e-9))
        sd = np.where(share < self.settings.narrowest, UNSEEN, told)
        cosine, sine = math.cos(before.yaw), math.sin(before.yaw)
        dx, dy, turn = pose.x - before.x, pose.y - before.y, wrapped(pose.yaw - before.yaw)
        back = rotation(turn) @ axes  # the walls' directions, as seen from the pose before
        covariance = np.zeros((3, 3))
        covariance[:2, :2] = (back * sd**2) @ back.T
        covariance[2, 2] = math.radians(self.settings.yaw) ** 2
        motion = np.array([cosine * dx + sine * dy, cosine * dy - sine * dx, turn])
        motion[:2] += back @ (sd * error[:2])
        motion[2] += math.radians(self.settings.yaw) * error[2]
        return Shift(motion, covariance)


def facing(scan: Scan) -> tuple[np.ndarray, np.ndarray]:
    """Which ways the seen walls face: shares (2,) that add up to 1, and their directions, the columns of (2, 2).

    All zero where nothing is seen. A wall is where returns SPAN beams apart are less than GAP metres apart.
    """
    x, y = scan.range * np.cos(scan.bearing), scan.range * np.sin(scan.bearing)
    along_x, along_y = np.append(x[SPAN:], x[:SPAN]) - x, np.append(y[SPAN:], y[:SPAN]) - y
    length = np.hypot(along_x, along_y)
    wall = (length < GAP) & (length > 0.0)  # false for nan
    if not wall.any():
        return np.zeros(2), np.eye(2)
    normal_x, normal_y = -along_y[wall] / length[wall], along_x[wall] / length[wall]
    xx, yy, xy = normal_x @ normal_x, normal_y @ normal_y, normal_x @ normal_y
    most = 0.5 + 0.5 * math.hypot(xx - yy, 2.0 * xy) / (xx + yy)
    return np.array([most, 1.0 - most]), rotation(0.5 * math.atan2(2.0 * xy, xx - yy))


def rotation(angle: float) -> np.ndarray:
    """(2, 2), to the left."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])
