"""Exploration on the robot's own map, without learning and without privileges (as explore_lite does it in ROS).

Input: the depth image, the LiDAR's scan (info["lidar"], where the robot has one) and the pose (info["estimate"] where
the robot has one, else info["pose"]). The agent keeps an
occupancy map across episodes and takes the fewest actions to a goal on it (Yamauchi 1997; goals.py). It has no access
to the scene.
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.lattice import Lattice
from curionav_cli.agents.mapper.goals import GOALS
from curionav_cli.agents.mapper.memory import Memory
from curionav_cli.constants import ACTIONS, FORWARD, HEADINGS
from curionav_cli.files import read_arrays, read_json, write_arrays
from curionav_cli.records import Pose
from curionav_cli.robot.depth_camera import DepthCamera
from curionav_cli.robot.measurements import Scan
from curionav_cli.world.motion import YAW

STUCK = 3  # cancelled moves in a row, after which it moves at random
SHUT_IN = 0.5  # of the cells that it visited; a search that reaches fewer says that the map is wrong around it
AGAIN = 5  # actions by which a goal counts as further away for each episode that ended with its cell blocked
PATIENCE = 50  # searches until it looks for a goal again, once there was none


class Mapper(Agent):
    """The agent of agent=mapper. goal: a name of GOALS.

    Where no goal is left it drives to cells not visited in this episode, so that changes are seen, and searches for a
    goal again after PATIENCE searches. Where it is shut in it forgets the obstacles around it.
    """

    sees = True

    def __init__(self, seed: int, camera: DepthCamera, memory: Memory, goal: str):
        super().__init__(seed)
        self.camera, self.memory, self.goal = camera, memory, goal
        self.steps, self.explored = 0, 0  # since the run began; when nothing was left for the first time
        self.way: list[int] = []
        self.wait = self.stuck = 0
        self.before: Pose | None = None
        self._seen = np.zeros(0, bool)  # of the searches

    def begin(self) -> None:
        self.memory.begin()
        self.way, self.wait, self.stuck, self.before = [], 0, 0, None

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        pose = Pose(*np.asarray(info.get("estimate", info["pose"])).tolist())
        self.stuck = self.stuck + 1 if info["collided"] else 0
        if self.stuck and self.before:
            self.memory.cancelled(*self.before)
            self.way = []
        self.memory.see(pose, self.camera.scan(observation["depth"]), self.camera.near, lidar(info))
        self.memory.land(pose.x, pose.y, (self.before or pose)[:2])
        if self.stuck > STUCK:
            self.way = []
        elif not self.way or not self._clear(pose):
            self.way = self._search(pose)
        self.steps, self.before = self.steps + 1, pose
        return self.way.pop(0) if self.way else int(self.rng.integers(len(ACTIONS)))

    def report(self) -> dict[str, float]:
        """explored: the step at which nothing was left for the first time, if it has come."""
        return {"explored": float(self.explored)} if self.explored else {}

    def save(self, folder: Path) -> None:
        super().save(folder)
        (folder / "mapper.json").write_text(json.dumps({"steps": self.steps, "explored": self.explored}))
        write_arrays(folder / "map.npz", self.memory.save())

    def load(self, folder: Path) -> None:
        super().load(folder)
        held = read_json(folder / "mapper.json")
        self.steps, self.explored = held["steps"], held["explored"]
        self.memory.load(read_arrays(folder / "map.npz", self.memory.SAVED, self.memory.LATER))

    def _clear(self, pose: Pose) -> bool:
        """Is the next action still possible, by what is known now?"""
        return self.way[0] != FORWARD or self._lattice(pose, self.memory.visited).clear(*self._at(pose))

    def _search(self, pose: Pose) -> list[int]:
        """The fewest actions to a goal, of which those that were blocked before count as further away; [] where nothing
        at all is left."""
        self.wait -= 1
        if self.wait <= 0:
            lattice = self._lattice(pose, GOALS[self.goal](self.memory, pose.x, pose.y), AGAIN * self.memory.blocked)
            way = lattice.search(*self._at(pose))
            if way:
                return way
            self._found_nothing(pose, lattice.reached)
        return self._lattice(pose, ~self.memory.today).search(*self._at(pose))

    def _found_nothing(self, pose: Pose, reached: int) -> None:
        """A search that reached so many cells found no goal: either the robot is shut in, or nothing is left."""
        if reached < SHUT_IN * self.memory.visited.sum():
            self.memory.forget(pose.x, pose.y)
        else:
            self.explored, self.wait = self.explored or self.steps, PATIENCE

    def _lattice(self, pose: Pose, goal: np.ndarray, further: np.ndarray | None = None) -> Lattice:
        """The search grid; its headings are turned by what the estimated yaw is off multiples of ten degrees."""
        turned = pose.yaw - YAW[self._heading(pose)]
        if len(self._seen) != goal.size * HEADINGS:
            self._seen = np.zeros(goal.size * HEADINGS, bool)
        return Lattice(self.memory.free, goal, self.memory.cell, turned, self._seen, further)

    def _at(self, pose: Pose) -> tuple[float, float, int]:
        """The pose on the map's grid."""
        corner = self.memory.map.corner
        return pose.x - corner[0], pose.y - corner[1], self._heading(pose)

    def _heading(self, pose: Pose) -> int:
        return round(pose.yaw / (2.0 * math.pi) * HEADINGS) % HEADINGS


def lidar(info: dict[str, Any]) -> Scan | None:
    """The LiDAR's scan in the info of a robot that has one; None for another."""
    if "lidar" not in info:
        return None
    bearing, length = info["lidar"]
    return Scan(bearing, length, 0.0)
