"""One homecoming: everything that takes the robot from where it is onto its dock, and the report of it."""

from __future__ import annotations

import math
from collections.abc import Callable

from curionav_cli.geometry import wrapped
from curionav_cli.records import DockReport, Pose
from curionav_cli.robot.charging_dock import seen_from
from curionav_cli.robot.docking.action import Code, Feedback, Goal
from curionav_cli.robot.docking.client import Client, Server
from curionav_cli.robot.docking.server import Docking
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.navigation import Navigator
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.robot.robot_base import RobotBase
from curionav_cli.robot.settings import Turtlebot

Link = Callable[[Docking], Server]


class ReturnToDock:
    """dock: where the robot believes its dock to be; link: what stands between client and server, nothing here."""

    def __init__(self, base: RobotBase, localiser: Localiser, occupancy: Occupancy, profile: Turtlebot, dock: Pose,
                 link: Link = lambda server: server):
        self.base, self.localiser, self.dock = base, localiser, dock
        self.homing = Navigator(base, localiser, occupancy, base.station.radius, profile.step)
        self.server = Docking(base, localiser, self.homing, profile.docking)
        self.client = Client(link(self.server), base, profile.docking.patience)
        self._arrival: Pose | None = None
        self._error: Pose | None = None

    def run(self) -> DockReport:
        """Drive home and dock. A person carries the robot where that fails, and the report says so."""
        away = self.base.witness()
        code, text = self.client.pursue(Goal(self.dock), self._heard)
        server = self.server
        return DockReport(
            code=code.name, text=text, human=code is not Code.docked, attempts=server.attempts,
            recoveries=tuple(server.recoveries), seconds=server.seconds, metres=self.homing.metres,
            distance=math.hypot(away.x, away.y), battery=self.base.battery.left / self.base.battery.capacity,
            arrival=self._arrival, error=self._error)

    def _heard(self, feedback: Feedback) -> None:
        """When the first approach begins: where it stands, and where it believes to stand, in the dock's frame."""
        if feedback.attempt and self._arrival is None:
            truth, belief = self.base.witness(), seen_from(self.dock, self.localiser.pose)
            self._arrival = truth
            self._error = Pose(belief.x - truth.x, belief.y - truth.y, wrapped(belief.yaw - truth.yaw))
