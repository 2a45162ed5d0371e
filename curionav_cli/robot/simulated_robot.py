"""The true robot: its pose, its world, its sensors.

Coverage, the images and the dock's geometry read `pose`. Planner, navigation, filter and map do not import this
module: they get its measurements (measurements.py).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.battery import Battery
from curionav_cli.robot.collision_world import CollisionWorld, Rectangle
from curionav_cli.robot.drive import Drive
from curionav_cli.robot.measurements import Reading, Scan
from curionav_cli.robot.sensors import RangeSensor, ScanMatcher, WheelsAndGyro
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.world.scene.scene import Scene

FRONT = math.radians(25.0)  # half of the bumper's middle third


class SimulatedRobot:
    """The true robot. pose: true; velocity: (m/s, rad/s) of the last command; silent: sensors that give nothing."""

    def __init__(self, profile: Turtlebot, generator: np.random.Generator, station: Rectangle | None = None):
        self.profile, self.battery = profile, Battery(profile.battery)
        self.station = station
        self._rngs = generator.spawn(5)
        self._drive_rng, inertial, lidar, depth, match = self._rngs
        self._wheels_and_gyro = WheelsAndGyro(profile.odometry, profile.gyro, inertial)
        self._lidar, self._depth = RangeSensor(profile.lidar, lidar), RangeSensor(profile.depth, depth)
        self._match = ScanMatcher(profile.scan_odometry, match)
        self.velocity, self.time = (0.0, 0.0), 0.0
        self.silent: set[str] = set()

    def place(self, scene: Scene, pose: Pose) -> None:
        """Put the robot at a pose of an episode's scene and draw new errors of scale and bias."""
        self.set_scene(scene)
        self.pose = Pose(*pose)
        self._wheels_and_gyro.begin_episode()
        self._match.reset()

    def set_scene(self, scene: Scene) -> None:
        """Change the scene around the robot, which stays at its pose."""
        self.collision_world = CollisionWorld(scene, self.station)
        self._drive = Drive(self.profile.drive, scene.plan.radius, self._drive_rng)

    def drive(self, distance: float, turn: float, seconds: float) -> Reading:
        """Drive a short arc or a whole step: metres, radians to the left, seconds."""
        self.velocity = (distance / seconds, turn / seconds)
        motion = self._drive.move(self.pose, distance, turn, self.collision_world)
        x, y, yaw = motion.pose
        self.pose = Pose(x, y, wrapped(yaw))
        self.time += seconds
        self.battery.drain(seconds)
        wheel, gyro = self._wheels_and_gyro.measure(motion.rolled, motion.turned, seconds)
        bump = self._bump() if motion.touched else None
        if self.silent:
            wheel, gyro = (math.nan if name in self.silent else value
                           for name, value in (("wheel", wheel), ("gyro", gyro)))
        return Reading(wheel, gyro, seconds, self.time, bump)

    def halt(self) -> None:
        """Set the velocity to zero."""
        self.velocity = (0.0, 0.0)

    def scan(self) -> Scan:
        """Take a LiDAR scan, all around, with the motion since the previous one."""
        scan = self._scan_with("lidar", self._lidar)
        return scan._replace(shift=self._match.shift(scan, self.pose))

    def no_scan(self) -> Scan:
        """A LiDAR scan without any return, as before the first one."""
        return Scan(self._lidar.bearing, np.full(len(self._lidar.bearing), np.nan), self.time)

    def depth(self) -> Scan:
        """Take the horizontal line of the depth camera, ahead."""
        return self._scan_with("depth", self._depth)

    def save(self) -> dict[str, Any]:
        """The state that `load` restores, but for the scene: call `set_scene` after it."""
        errors = self._wheels_and_gyro
        return {"pose": list(self.pose), "battery": self.battery.left, "time": self.time,
                "scanned": self._match.before and list(self._match.before),
                "errors": [errors.scale, errors.turn_scale, errors.bias],
                "rng": [rng.bit_generator.state for rng in self._rngs]}

    def load(self, state: dict[str, Any]) -> None:
        """Restore the state of `save`."""
        self.pose, self.battery.left, self.time = Pose(*state["pose"]), state["battery"], state["time"]
        self._match.before = state["scanned"] and Pose(*state["scanned"])
        self._wheels_and_gyro.scale, self._wheels_and_gyro.turn_scale, self._wheels_and_gyro.bias = state["errors"]
        for rng, saved in zip(self._rngs, state["rng"], strict=True):
            rng.bit_generator.state = saved

    def _scan_with(self, name: str, sensor: RangeSensor) -> Scan:
        scan = sensor.scan(self.pose, self.collision_world, self.time)
        return scan._replace(range=np.full_like(scan.range, np.nan)) if name in self.silent else scan

    def _bump(self) -> str | None:
        at = self.collision_world.touching(self.pose.x, self.pose.y, self._drive.radius)
        if at is None or "bumper" in self.silent:
            return None
        side = wrapped(at - self.pose.yaw)
        if abs(side) > math.pi / 2.0:
            return None  # the bumper covers the front half
        return "centre" if abs(side) < FRONT else "left" if side > 0.0 else "right"
