"""The true robot: the only thing that knows where it is and what stands around it.

Coverage, the pictures and docking's geometry read `pose`. Planner, homing, filter and map do not import this
module: they know what it senses (measurements.py).
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
from curionav_cli.robot.measurements import Scan, Sensed
from curionav_cli.robot.sensors import Inertia, Ranger, ScanMatch
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.world.scene.scene import Scene

FRONT = math.radians(25.0)  # half of the bumper's middle third


class SimulatedRobot:
    """pose: where it truly is. velocity: (m/s, rad/s) of the last command. silent: sensors that give nothing."""

    def __init__(self, profile: Turtlebot, generator: np.random.Generator, station: Rectangle | None = None):
        self.profile, self.battery = profile, Battery(profile.battery)
        self.station = station
        self._rngs = generator.spawn(5)
        drive, inertia, lidar, depth, match = self._rngs
        self._drive_rng = drive
        self._inertia = Inertia(profile.odometry, profile.gyro, inertia)
        self._lidar, self._depth = Ranger(profile.lidar, lidar), Ranger(profile.depth, depth)
        self._match = ScanMatch(profile.scan_odometry, match)
        self.velocity, self.time = (0.0, 0.0), 0.0
        self.silent: set[str] = set()

    def enter(self, scene: Scene, pose: Pose) -> None:
        """Stand at a pose of an episode's scene, fresh from the dock: its errors of scale and bias are others."""
        self.around(scene)
        self.pose = Pose(*pose)
        self._inertia.rest()
        self._match.forget()

    def around(self, scene: Scene) -> None:
        """The world around it is another, and it stands where it stood."""
        self.surroundings = CollisionWorld(scene, self.station)
        self._drive = Drive(self.profile.drive, scene.plan.radius, self._drive_rng)

    def drive(self, distance: float, turn: float, seconds: float) -> Sensed:
        """One short arc, or a whole step: metres, radians to the left, seconds."""
        self.velocity = (distance / seconds, turn / seconds)
        motion = self._drive.move(self.pose, distance, turn, self.surroundings)
        x, y, yaw = motion.pose
        self.pose = Pose(x, y, wrapped(yaw))
        self.time += seconds
        self.battery.drain(seconds)
        wheel, gyro = self._inertia.measure(motion.rolled, motion.turned, seconds)
        bump = self._bump() if motion.touched else None
        if self.silent:
            wheel, gyro = (math.nan if name in self.silent else value
                           for name, value in (("wheel", wheel), ("gyro", gyro)))
        return Sensed(wheel, gyro, seconds, self.time, bump)

    def halt(self) -> None:
        """Zero velocity."""
        self.velocity = (0.0, 0.0)

    def scan(self) -> Scan:
        """The LiDAR, all around, and how the robot moved since it last looked."""
        scan = self._look("lidar", self._lidar)
        return scan._replace(shift=self._match.shift(scan, self.pose))

    def depth(self) -> Scan:
        """The horizontal line of the depth camera, ahead."""
        return self._look("depth", self._depth)

    def save(self) -> dict[str, Any]:
        """All that `load` needs, but for the scene: `around` comes after it."""
        inertia = self._inertia
        return {"pose": list(self.pose), "battery": self.battery.left, "time": self.time,
                "scanned": self._match.before and list(self._match.before),
                "errors": [inertia.scale, inertia.turn_scale, inertia.bias],
                "rng": [rng.bit_generator.state for rng in self._rngs]}

    def load(self, state: dict[str, Any]) -> None:
        self.pose, self.battery.left, self.time = Pose(*state["pose"]), state["battery"], state["time"]
        self._match.before = state["scanned"] and Pose(*state["scanned"])
        self._inertia.scale, self._inertia.turn_scale, self._inertia.bias = state["errors"]
        for rng, saved in zip(self._rngs, state["rng"], strict=True):
            rng.bit_generator.state = saved

    def _look(self, name: str, sensor: Ranger) -> Scan:
        scan = sensor.scan(self.pose, self.surroundings, self.time)
        return scan._replace(range=np.full_like(scan.range, np.nan)) if name in self.silent else scan

    def _bump(self) -> str | None:
        at = self.surroundings.touching(self.pose.x, self.pose.y, self._drive.radius)
        if at is None or "bumper" in self.silent:
            return None
        side = wrapped(at - self.pose.yaw)
        if abs(side) > math.pi / 2.0:
            return None  # the bumper covers the front half
        return "centre" if abs(side) < FRONT else "left" if side > 0.0 else "right"
