"""Wheel encoders, gyro, LiDAR and depth camera: what is true in, what the robot gets out."""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.config.robot_schema import Gyro, Odometry, Rays
from curionav_cli.records import Pose
from curionav_cli.robot.sensed import Scan
from curionav_cli.robot.surroundings import Surroundings


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

    def scan(self, pose: Pose, around: Surroundings, time: float) -> Scan:
        """Ranges from a pose; nothing is seen that is nearer than `blind` metres, nor through it."""
        angle = pose.yaw + self.bearing
        found = around.ranges(pose.x, pose.y, np.cos(angle), np.sin(angle), self.settings.far)
        unseen = (found < self.settings.blind) | ~np.isfinite(found)
        found += self.settings.noise * self.rng.standard_normal(len(found))
        found[unseen] = np.nan
        return Scan(self.bearing, found, time)
