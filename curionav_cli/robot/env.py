"""The robot as a Gymnasium environment: the actions of NavigationEnv, executed with drift and a battery."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

from curionav_cli.constants import ACTIONS, FORWARD, IMAGE_SHAPE, LEFT, RIGHT, STEP_LENGTH, TURN_ANGLE, Stream
from curionav_cli.files import read_arrays, read_json, write_arrays
from curionav_cli.records import Pose
from curionav_cli.robot.charging_dock import ChargingDock
from curionav_cli.robot.corridor import occupied
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.ndt_matcher import NdtMap
from curionav_cli.robot.occupancy import Occupancy
from curionav_cli.robot.return_to_dock import Link, ReturnToDock
from curionav_cli.robot.robot_base import RobotBase
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.robot.simulated_robot import SimulatedRobot
from curionav_cli.world.env import NavigationEnv, Observation, step_info
from curionav_cli.world.resets import seed_of

TURNS = {LEFT: TURN_ANGLE, RIGHT: -TURN_ANGLE}


class RobotEnv(gymnasium.Wrapper):
    """Actions and observations of NavigationEnv. Observations and info["pose"] are those of the true pose.

    info also has estimate (3,), the estimated pose; lidar (2, beams), bearings from the heading in radians and ranges
    in metres, nan without a return and before the first step; and after a reset dock, the report of the return to dock
    as a dict or None. A step is truncated when the battery is down to the reserve for the return. pictures=False:
    images and depths are zeros, for agents that do not use them. link: wraps the docking server for its client.
    """

    env: NavigationEnv

    def __init__(self, env: NavigationEnv, profile: Turtlebot, pictures: bool = True,
                 link: Link = lambda server: server):
        super().__init__(env)
        self.profile, self.pictures, self.link = profile, pictures, link
        self._restored: dict[str, Any] | None = None
        self._seed = 0

    def reset(self, *, seed: int | None = None,
              options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """reset(seed) starts a run at the dock, or continues the one of `load`; reset() returns to the dock and starts
        the next episode."""
        seed = seed_of(seed)
        begins = seed is not None or self.env.counter.episode < 0
        if begins:
            self._start_run(seed or 0)
        dock = self._return_to_dock() if self._restored or not begins else None
        self._restored = None
        _, info = self.env.reset(seed=seed, options=options)
        self._episode = int(info["episode_index"])
        self.body.place(self.env.now, self._start_pose())  # docked, or carried by a person where docking failed
        self.localiser.leave_dock(self.env.scene.plan.start)
        self.body.battery.charge()
        self.map = Occupancy()
        self.env.reward.reset(self.env.now.plan, *self.body.pose[:2])
        self._scan = self.body.no_scan()
        return self._observe(), {**self._info(False), "dock": dock}

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        self.env.counter.require()
        if action not in ACTIONS:
            raise ValueError(f"action {action!r} is none of 0 forward, 1 left, 2 right")
        seconds = self.profile.step
        if action == FORWARD and self._corridor_occupied():
            reading, collided = self.body.drive(0.0, 0.0, seconds), True
        elif action == FORWARD:
            reading = self.body.drive(STEP_LENGTH, 0.0, seconds)
            collided = reading.bump is not None
        else:
            reading, collided = self.body.drive(0.0, TURNS[action], seconds), False
        self._scan = self.body.scan()
        self.localiser.update(reading, self._scan)
        self.map.integrate_scan(self.localiser.pose, self._scan)
        earned = self.env.reward.step(*self.body.pose[:2])
        return self._observe(), earned, False, self.body.battery.low, self._info(collided)

    def save(self, folder: Path) -> None:
        """Write the state at the end of an episode, which `load` restores."""
        state = {"episode": self._episode, "body": self.body.save(), "localiser": self.localiser.save()}
        (folder / "robot.json").write_text(json.dumps(state))
        write_arrays(folder / "robot_map.npz", self.map.save() | self.localiser.ndt_map.save())

    def load(self, folder: Path) -> None:
        """Restore the end of the saved episode: the next reset(seed=...) returns to the dock from there."""
        arrays = read_arrays(folder / "robot_map.npz", Occupancy.SAVED + NdtMap.SAVED)
        self._restored = {**read_json(folder / "robot.json"), "map": arrays}

    def _start_run(self, seed: int) -> None:
        start, self._seed = self.env.scene.plan.start, seed
        station = ChargingDock(self.env.scene.dock, self.env.scene.plan.radius, self.profile.docking.contact)
        self.body = SimulatedRobot(self.profile, np.random.default_rng([seed, Stream.robot]), station.outline)
        self.localiser = Localiser(self.profile, start)
        if self._restored:
            self.body.load(self._restored["body"])
            self.body.set_scene(self.env.scene.at(self._restored["episode"], seed)[0])
            self.localiser.load(self._restored["localiser"], self._restored["map"])
            self.map, self._episode = Occupancy.of(self._restored["map"]), self._restored["episode"]

    def _start_pose(self) -> Pose:
        """The true pose at which an episode begins: the start, with the error that contacts and undocking leave."""
        start, dock = self.env.scene.plan.start, self.profile.filter
        x, y, yaw = np.random.default_rng([self._seed, Stream.start, self._episode]).standard_normal(3).tolist()
        return Pose(start.x + dock.dock_position * x, start.y + dock.dock_position * y,
                    start.yaw + math.radians(dock.dock_yaw) * yaw)

    def _return_to_dock(self) -> dict[str, Any] | None:
        """Return to the dock, in the scene of the episode that ends; the report as a dict."""
        scene = self.env.scene
        light = np.random.default_rng([self._seed, Stream.dock, self._episode])
        base = RobotBase(self.body, scene.dock, scene.plan.radius, self.profile, light)
        return asdict(ReturnToDock(base, self.localiser, self.map, self.profile, scene.dock, self.link).run())

    def _corridor_occupied(self) -> bool:
        """True when depth shows an obstacle in the corridor of a forward move; nearer than `blind` it shows none."""
        if self.body.collision_world.has_room(*self.body.pose[:2], STEP_LENGTH + 2 * self.env.scene.plan.radius):
            return False
        return occupied(self.body.depth(), self.env.scene.plan.radius, STEP_LENGTH)

    def _observe(self) -> Observation:
        if not self.pictures:
            return BLANK
        views = self.env.look(*self.body.pose)
        return {"image": views["image"][0], "depth": views["depth"][0]}

    def _info(self, collided: bool) -> dict[str, Any]:
        return step_info(self.body.pose, collided, self._episode) | {
            "estimate": np.array(self.localiser.pose), "lidar": np.stack([self._scan.bearing, self._scan.range])}


BLANK: Observation = {"image": np.zeros(IMAGE_SHAPE, np.uint8), "depth": np.zeros(IMAGE_SHAPE[:2], np.float32)}
