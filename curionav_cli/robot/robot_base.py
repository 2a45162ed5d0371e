"""The simulated robot as navigation and docking use it (interface.Base): the true body, its dock, infrared light.

The only module that holds both the body and the charging dock.
"""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.battery import Battery
from curionav_cli.robot.charging_dock import ChargingDock
from curionav_cli.robot.infrared import Infrared, Signals
from curionav_cli.robot.measurements import Reading, Scan
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.robot.simulated_robot import SimulatedRobot

SIGHT_STEP = 0.02  # metres; within it the line of sight is not computed again


class RobotBase:
    """interface.Base in simulation. dock: its true pose; radius: of the robot, metres; generator: for missed frames.

    The bumper is also pressed by the dock, which the body alone does not report.
    """

    hazard: str | None = None  # wheel_drop or cliff: a simulated floor has neither

    def __init__(self, body: SimulatedRobot, dock: Pose, radius: float, profile: Turtlebot,
                 generator: np.random.Generator):
        self.body, self.station = body, ChargingDock(dock, radius, profile.docking.contact)
        self.infrared = Infrared(profile.docking.infrared, self.station, generator, self._in_sight)
        self._sight_from, self._sight_free = (math.inf, math.inf), False

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

    def drive(self, distance: float, turn: float, seconds: float) -> Reading:
        bump = self._pressed_side(distance)
        reading = self.body.drive(0.0 if bump else distance, turn, seconds)
        return reading._replace(bump=bump) if bump and "bumper" not in self.silent else reading

    def halt(self) -> None:
        self.body.halt()

    def scan(self) -> Scan:
        return self.body.scan()

    def depth(self) -> Scan:
        return self.body.depth()

    def signals(self) -> Signals:
        return (0, 0, 0) if "infrared" in self.silent else self.infrared.receive(self.body.pose)

    def true_pose(self) -> Pose:
        """The true pose in the dock's frame, for reports only."""
        return self.station.relative(self.body.pose)

    def _pressed_side(self, distance: float) -> str | None:
        """The third of the bumper that the dock presses if the robot drives on, or None."""
        pose = self.body.pose
        if distance <= 0.0 or not self.station.touched(pose):
            return None
        side = wrapped(self.station.direction(pose) - pose.yaw)
        if abs(side) > math.pi / 2.0:
            return None
        return "centre" if abs(side) < math.radians(25.0) else "left" if side > 0.0 else "right"

    def _in_sight(self, x: float, y: float, dock_x: float, dock_y: float) -> bool:
        if math.hypot(x - self._sight_from[0], y - self._sight_from[1]) > SIGHT_STEP:
            away = math.hypot(dock_x - x, dock_y - y)
            along = np.array([(dock_x - x) / away]), np.array([(dock_y - y) / away])
            self._sight_free = bool(self.body.collision_world.ranges(x, y, *along, away)[0] >= away - SIGHT_STEP)
            self._sight_from = (x, y)
        return self._sight_free
