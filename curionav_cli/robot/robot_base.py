"""The robot as homing and docking get it (docking.nouns.Base): the true body, the station before it, and the light.

Only this module knows both the body and the station; behind it stand motors and sensors alone.
"""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.battery import Battery
from curionav_cli.robot.charging_dock import ChargingDock
from curionav_cli.robot.infrared import Infrared, Signals
from curionav_cli.robot.measurements import Scan, Sensed
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.robot.simulated_robot import SimulatedRobot

BLIND = 0.02  # metres; over so short a way what blocks the light stays the same


class RobotBase:
    """The station's bumps are told here, since it is where contacts meet."""

    hazard: str | None = None  # wheel_drop or cliff: a simulated floor has neither

    def __init__(self, body: SimulatedRobot, dock: Pose, radius: float, profile: Turtlebot,
                 generator: np.random.Generator):
        self.body, self.station = body, ChargingDock(dock, radius, profile.docking.contact)
        self.infrared = Infrared(profile.docking.infrared, self.station, generator, self._in_sight)
        self._looked, self._free = (math.inf, math.inf), False

    @property
    def velocity(self) -> tuple[float, float]:
        return self.body.velocity

    @property
    def battery(self) -> Battery:
        return self.body.battery

    @property
    def silent(self) -> set[str]:
        return self.body.silent

    @property
    def charging(self) -> bool:
        return self.station.charging(self.body.pose)

    def drive(self, distance: float, turn: float, seconds: float) -> Sensed:
        bump = self._against(distance)
        sensed = self.body.drive(0.0 if bump else distance, turn, seconds)
        return sensed._replace(bump=bump) if bump and "bumper" not in self.silent else sensed

    def halt(self) -> None:
        self.body.halt()

    def scan(self) -> Scan:
        return self.body.scan()

    def depth(self) -> Scan:
        return self.body.depth()

    def signals(self) -> Signals:
        return (0, 0, 0) if "infrared" in self.silent else self.infrared.see(self.body.pose)

    def witness(self) -> Pose:
        """The true pose in the dock's frame: for reports, which say what the robot could not know."""
        return self.station.relative(self.body.pose)

    def _against(self, distance: float) -> str | None:
        """Where the bumper is pressed by the station if the robot drives on, or None."""
        pose = self.body.pose
        if distance <= 0.0 or not self.station.touched(pose):
            return None
        side = wrapped(self.station.direction(pose) - pose.yaw)
        if abs(side) > math.pi / 2.0:
            return None
        return "centre" if abs(side) < math.radians(25.0) else "left" if side > 0.0 else "right"

    def _in_sight(self, x: float, y: float, dock_x: float, dock_y: float) -> bool:
        if math.hypot(x - self._looked[0], y - self._looked[1]) > BLIND:
            away = math.hypot(dock_x - x, dock_y - y)
            along = np.array([(dock_x - x) / away]), np.array([(dock_y - y) / away])
            self._free = bool(self.body.surroundings.ranges(x, y, *along, away)[0] >= away - BLIND)
            self._looked = (x, y)
        return self._free
