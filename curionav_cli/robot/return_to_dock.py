"""One return to dock: navigation, docking and the report, from wherever the robot stands."""

from __future__ import annotations

import math
from collections.abc import Callable

from curionav_cli.geometry import wrapped
from curionav_cli.records import DockReport, Pose
from curionav_cli.robot.charging_dock import in_dock_frame
from curionav_cli.robot.docking.action import Code, Feedback, Goal
from curionav_cli.robot.docking.client import ActionServer, DockingClient
from curionav_cli.robot.docking.server import DockingServer
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.navigation import Navigator
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.robot.robot_base import RobotBase
from curionav_cli.robot.settings import Turtlebot

Link = Callable[[DockingServer], ActionServer]


class ReturnToDock:
    """A robot with its docking client and server. dock: its estimated pose; link: wraps the server for the client."""

    def __init__(self, base: RobotBase, localiser: Localiser, occupancy: Occupancy, profile: Turtlebot, dock: Pose,
                 link: Link = lambda server: server):
        self.base, self.localiser, self.dock = base, localiser, dock
        self.navigator = Navigator(base, localiser, occupancy, base.station.radius, profile.step)
        self.server = DockingServer(base, localiser, self.navigator, profile.docking)
        self.client = DockingClient(link(self.server), base, profile.docking.patience)
        self._arrival: Pose | None = None
        self._error: Pose | None = None

    def run(self) -> DockReport:
        """Return and dock; human=True in the report where that failed, so that a person has to carry the robot."""
        start = self.base.true_pose()
        code, text = self.client.send_goal_and_wait(Goal(self.dock), self._on_feedback)
        server = self.server
        return DockReport(
            code=code.name, text=text, human=code is not Code.docked, attempts=server.attempts,
            recoveries=tuple(server.recoveries), seconds=server.seconds, metres=self.navigator.metres,
            distance=math.hypot(start.x, start.y), battery=self.base.battery.left / self.base.battery.capacity,
            arrival=self._arrival, error=self._error)

    def _on_feedback(self, feedback: Feedback) -> None:
        """Record true pose and error of the estimate, in the dock's frame, when the first approach begins."""
        if feedback.attempt and self._arrival is None:
            truth, estimate = self.base.true_pose(), in_dock_frame(self.dock, self.localiser.pose)
            self._arrival = truth
            self._error = Pose(estimate.x - truth.x, estimate.y - truth.y, wrapped(estimate.yaw - truth.yaw))
