"""Simulated sensors: wheel encoders, gyro, LiDAR, depth camera, scan odometry. True state in, measurements out."""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.collision_world import CollisionWorld
from curionav_cli.robot.measurements import Scan, Shift
from curionav_cli.robot.settings import Gyro, Odometry, Rays, ScanOdometry

UNOBSERVED = 1.0  # metres; sd of a motion along a direction that the scans do not observe
GAP, SPAN = 0.5, 4


class WheelsAndGyro:
    """Wheel encoders and gyro: errors of scale are drawn for each episode, and the gyro bias is a random walk."""

    def __init__(self, odometry: Odometry, gyro: Gyro, generator: np.random.Generator):
        self.odometry, self.gyro, self.rng = odometry, gyro, generator
        self.begin_episode()

    def begin_episode(self) -> None:
        """Draw the errors of scale, and what is left of the gyro bias after resting on the dock."""
        scale, turn, bias = self.rng.standard_normal(3).tolist()
        self.scale, self.turn_scale = scale * self.odometry.scale, turn * self.gyro.scale
        self.bias = math.radians(bias * self.gyro.bias)  # rad / s

    def measure(self, rolled: float, turned: float, seconds: float) -> tuple[float, float]:
        """Measure a move: (wheel, gyro) in metres and radians. rolled: metres; turned: radians."""
        wheel, gyro, walk = self.rng.standard_normal(3).tolist()
        root = math.sqrt(seconds)
        rate = turned * (1.0 + self.turn_scale) + self.bias * seconds + math.radians(gyro * self.gyro.noise) * root
        self.bias += math.radians(walk * self.gyro.walk) * root
        return rolled * (1.0 + self.scale) + wheel * self.odometry.noise * math.sqrt(abs(rolled)), rate


class RangeSensor:
    """A range sensor: a fan of rays from the robot's centre."""

    def __init__(self, settings: Rays, generator: np.random.Generator):
        self.settings, self.rng = settings, generator
        half = math.radians(settings.view) / 2.0
        step = 2.0 * half / (settings.beams if settings.view == 360 else settings.beams - 1)
        self.bearing = -half + step * np.arange(settings.beams)

    def scan(self, pose: Pose, world: CollisionWorld, time: float) -> Scan:
        """Take a scan from a true pose; a ray that meets something nearer than `blind` metres gives nan."""
        angle = pose.yaw + self.bearing
        found = world.ranges(pose.x, pose.y, np.cos(angle), np.sin(angle), self.settings.far)
        unseen = (found < self.settings.blind) | ~np.isfinite(found)
        found += self.settings.noise * self.rng.standard_normal(len(found))
        found[unseen] = np.nan
        return Scan(self.bearing, found, time)


class ScanMatcher:
    """Scan odometry: the true motion since the previous scan plus an error drawn from the stated covariance, which is
    large along walls that all face one way."""

    def __init__(self, settings: ScanOdometry, generator: np.random.Generator):
        self.settings, self.rng = settings, generator
        self.before: Pose | None = None

    def reset(self) -> None:
        """Drop the previous scan."""
        self.before = None

    def shift(self, scan: Scan, pose: Pose) -> Shift | None:
        """The motion from the previous scan to this one, taken at `pose`; None for the first, or without returns."""
        before, self.before = self.before, pose
        share, axes = wall_directions(scan)
        error = self.rng.standard_normal(3)
        if before is None or not share.any():
            self.before = pose if share.any() else None
            return None
        observed = self.settings.position / np.sqrt(2.0 * np.maximum(share, 1e-9))
        sd = np.where(share < self.settings.narrowest, UNOBSERVED, observed)
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


def wall_directions(scan: Scan) -> tuple[np.ndarray, np.ndarray]:
    """The directions that the walls in a scan face: shares (2,) that add up to 1, and directions, columns of (2, 2).

    Shares are zero where there is no wall. A wall is where returns SPAN beams apart are less than GAP metres apart.
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
    """The (2, 2) rotation matrix of `angle` radians to the left."""
    cosine, sine = math.cos(angle), math.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])
