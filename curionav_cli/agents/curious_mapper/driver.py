"""The mapping explorer's driving with other goals: the place of the highest rate of expected surprise."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from curionav_cli.agents.curious_mapper.foraging import best_way, within_reach
from curionav_cli.agents.curious_mapper.memory import SurpriseMemory
from curionav_cli.agents.curious_mapper.settings import Surprise
from curionav_cli.agents.mapper.agent import Mapper
from curionav_cli.records import Pose
from curionav_cli.robot.depth_camera import DepthCamera

AGAIN = 10  # actions of a way, after which it is planned anew


class Driver(Mapper):
    """Maps and drives as agent=mapper; where no place is worth a visit, it drives to the nearest one not yet visited
    in this episode. stay: actions, as in foraging.py."""

    memory: SurpriseMemory

    def __init__(self, seed: int, camera: DepthCamera, memory: SurpriseMemory, stay: float, surprise: Surprise):
        super().__init__(seed, camera, memory, "unvisited")
        self.stay, self.surprise = stay, surprise
        self.planned = 0

    def add_measurement(self, surprise: float | None) -> None:
        """The surprise of the view that `act` is called with next, in nats; None where it was not measured.

        A view more surprising than a place not yet seen is expected to be has the way planned anew.
        """
        levels, self.memory.measured = self.memory.levels, None
        if surprise is None:
            return
        levels.add(surprise)
        ascribed = float(self.rng.choice(levels.recent)) if self.surprise is Surprise.shuffled else surprise
        self.memory.measured = ascribed
        if ascribed > levels.expected:
            self.way = []

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        self.planned += 1
        if self.planned > AGAIN:
            self.way = []
        return super().act(observation, info)

    def _search(self, pose: Pose) -> list[int]:
        self.planned = 0
        worth = self._worth(pose)
        if not worth[~self.memory.visited].any():
            self.explored = self.explored or self.steps
        way = best_way(self._lattice(pose, self.memory.today), *self._at(pose), worth, self.stay)
        return way or self._lattice(pose, ~self.memory.today).search(*self._at(pose))

    def _worth(self, pose: Pose) -> np.ndarray:
        """(rows, columns) float32: what a visit is worth, of the cells that can be reached."""
        memory = self.memory
        row, column = (int(index) for index in memory.map.cells(pose.x, pose.y))
        near = math.ceil(self.camera.near / memory.cell) + 1
        worth = memory.worth_of_visits() if self.surprise is Surprise.visits else memory.worth_of_surprise()
        return worth * within_reach(memory.free, memory.map.known, row, column, near)
