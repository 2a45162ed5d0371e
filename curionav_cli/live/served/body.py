"""The body of a served robot: continuous motion of the simulated robot at a fixed rate, and its odometry."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from curionav_cli.constants import Stream
from curionav_cli.geometry import wrapped
from curionav_cli.live.served.settings import Serving, without_errors
from curionav_cli.records import Pose
from curionav_cli.robot.charging_dock import ChargingDock
from curionav_cli.robot.infrared import sectors
from curionav_cli.robot.measurements import Reading
from curionav_cli.robot.robot_base import RobotBase
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.robot.simulated_robot import SimulatedRobot
from curionav_cli.world.scene.scene import Scene

RATE = 50  # Hz
TICK = 1.0 / RATE  # seconds
GAP = 2e-3  # metres between a docked robot and the station; the contacts reach farther (charging_dock.TOUCH)


class ServedBody(RobotBase):
    """RobotBase whose motion, whoever commands it, is made of ticks of 1 / RATE seconds. after: called behind each.

    odometry: the pose by wheels and gyro, from where it started; reading: of the last tick; ticks: since the start.
    docked: whether there is a dock and it starts there, else at the scene's start.
    """

    def __init__(self, scene: Scene, profile: Turtlebot, serving: Serving, seed: int, docked: bool):
        self.profile = without_errors(profile) if serving.exact else profile
        self.scene, self.recharge, self.docks = scene, serving.recharge, docked
        radius, contact = scene.plan.radius, profile.docking.contact
        station = ChargingDock(scene.dock, radius, contact).outline if docked else None
        body = SimulatedRobot(self.profile, np.random.default_rng([seed, Stream.robot]), station)
        super().__init__(body, scene.dock, radius, self.profile, np.random.default_rng([seed, Stream.dock]))
        self.put_back()
        self.odometry, self.ticks = Pose(0.0, 0.0, 0.0), 0
        self._turned, self._turned_at = 0.0, 0
        self.reading = Reading(0.0, 0.0, TICK, 0.0)
        self.after: Callable[[], None] = lambda: None

    @property
    def charging(self) -> bool:
        return self.docks and super().charging

    @property
    def sees_dock(self) -> bool:
        """Whether the dock's light reaches the robot; unlike `signals` it does not take a frame of the receivers."""
        here, dock = self.body.pose, self.station.emitter
        towards = math.atan2(here.y - dock.y, here.x - dock.x)
        lit = sectors(self.infrared.light, math.hypot(here.x - dock.x, here.y - dock.y), wrapped(towards - dock.yaw))
        return self.docks and bool(lit) and self._in_sight(here.x, here.y, dock.x, dock.y)

    @property
    def time(self) -> float:
        """Simulated seconds since the start."""
        return self.ticks * TICK

    def put_back(self) -> None:
        """Put the robot where it begins, as a person would; its wheels do not turn on the way."""
        self.body.place(self.scene, docked_pose(self.scene.dock) if self.docks else self.scene.plan.start)

    def drive(self, distance: float, turn: float, seconds: float) -> Reading:
        """Drive an arc in whole ticks, at least one; returns their readings as one."""
        ticks = max(1, round(seconds * RATE))
        parts = [self.tick(distance / ticks, turn / ticks) for _ in range(ticks)]
        bump = next((part.bump for part in reversed(parts) if part.bump), None)
        return Reading(math.fsum(part.wheel for part in parts), math.fsum(part.gyro for part in parts), ticks * TICK,
                       self.time, bump)

    def tick(self, distance: float, turn: float) -> Reading:
        """Drive for a tick; an empty battery turns no wheel."""
        if self.battery.empty:
            distance = turn = 0.0
        self.reading = super().drive(distance, turn, TICK) if self.docks else self.body.drive(distance, turn, TICK)
        self.ticks += 1
        self._sum_up(self.reading)
        if self.charging:
            battery = self.body.battery
            battery.left = min(battery.capacity, battery.left + TICK * (1.0 + battery.capacity / self.recharge))
        self.after()
        return self.reading

    def rate(self) -> float:
        """The gyro's mean rate since this was last asked, rad/s to the left, so that none of a turn is lost."""
        mean = self._turned / (TICK * max(1, self.ticks - self._turned_at))
        self._turned, self._turned_at = 0.0, self.ticks
        return mean

    def _sum_up(self, reading: Reading) -> None:
        self._turned += reading.gyro
        x, y, yaw = self.odometry
        heading = yaw + 0.5 * reading.gyro
        self.odometry = Pose(x + reading.wheel * math.cos(heading), y + reading.wheel * math.sin(heading),
                             wrapped(yaw + reading.gyro))


def docked_pose(dock: Pose) -> Pose:
    """The pose of a robot that stands on its dock, its front to the station, as near as a drive brings it."""
    return Pose(dock.x + GAP * math.cos(dock.yaw), dock.y + GAP * math.sin(dock.yaw), wrapped(dock.yaw + math.pi))
