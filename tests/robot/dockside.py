"""A real robot in the small room, at any place of it, with its docking server: for tests of the return to dock."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from curionav_cli import build
from curionav_cli.config.compose import compose
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.schema import Config
from curionav_cli.config.sources import opened
from curionav_cli.records import Pose
from curionav_cli.robot.charging_dock import ChargingDock
from curionav_cli.robot.docking.action import Feedback, Goal
from curionav_cli.robot.docking.server import DockingServer
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.navigation import Navigator
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.robot.robot_base import RobotBase
from curionav_cli.robot.simulated_robot import SimulatedRobot
from curionav_cli.world.scene.scene import Scene


@cache
def composed(env: str = "small_room", robot: str = "turtlebot2i") -> tuple[Config, Scene]:
    words = [f"env={env}", f"robot={robot}", "agent=bounce"]
    with opened("dock") as hydra:
        settings, _ = compose(hydra, OverrideErrors(hydra, words), words)
    return settings, build.scene(settings)


class Dockside:
    """A robot with its server. at: (metres before the dock, metres to its left, degrees off facing it).

    estimate_error: of the localiser's start, metres away from the dock and to its left.
    """

    def __init__(self, at: tuple[float, float, float] = (1.0, 0.0, 0.0),
                 estimate_error: tuple[float, float] = (0.0, 0.0), seed: int = 0, **docking: Any):
        settings, self.scene = composed()
        self.profile = replace(settings.robot, docking=replace(settings.robot.docking, **docking))
        dock = self.scene.dock
        ahead = np.array([math.cos(dock.yaw), math.sin(dock.yaw)])
        aside = np.array([-ahead[1], ahead[0]])
        place = np.array(dock[:2]) + at[0] * ahead + at[1] * aside
        wrong = estimate_error[0] * ahead + estimate_error[1] * aside
        yaw = dock.yaw + math.pi + math.radians(at[2])
        station = ChargingDock(dock, self.scene.plan.radius, self.profile.docking.contact)
        self.body = SimulatedRobot(self.profile, np.random.default_rng(seed), station.outline)
        self.body.place(self.scene, Pose(float(place[0]), float(place[1]), yaw))
        self.base = RobotBase(self.body, dock, self.scene.plan.radius, self.profile, np.random.default_rng(seed + 1))
        self.localiser = Localiser(self.profile, Pose(float(place[0] + wrong[0]), float(place[1] + wrong[1]), yaw))
        self.map = Occupancy()
        self.map.insert(self.localiser.pose, self.body.scan())
        self.navigator = Navigator(self.base, self.localiser, self.map, self.scene.plan.radius, self.profile.step)
        self.server = DockingServer(self.base, self.localiser, self.navigator, self.profile.docking)

    def send_goal(self, navigate: bool = True) -> Dockside:
        self.server.request(Goal(self.scene.dock, navigate))
        return self

    def until(self, done, ticks: int = 9000) -> Feedback:
        """Tick until done(feedback), or the goal has ended."""
        for _ in range(ticks):
            feedback = self.server.tick()
            if self.server.code or done(feedback):
                return feedback
        raise AssertionError(f"no result in {ticks} ticks: {feedback}")

    def result(self) -> str:
        """Tick until the goal ends; the name of its code. The wheels stand still then, and stay so."""
        self.until(lambda feedback: False)
        assert self.base.velocity == (0.0, 0.0)
        before = self.body.pose
        self.server.tick()
        assert self.body.pose == before and self.base.velocity == (0.0, 0.0)
        assert self.server.code is not None
        return self.server.code.name
