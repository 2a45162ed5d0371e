"""An oracle with map access: the shortest way, in actions, to the nearest cell not yet landed on.

It looks where it is before it acts, so that the cell on which an episode ended stays new to it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.lattice import Lattice
from curionav_cli.constants import ACTIONS, HEADINGS
from curionav_cli.files import read_json
from curionav_cli.records import FloorPlan
from curionav_cli.world.scene.scene import Scene

PATIENCE = 50  # random steps before it searches again, once no new cell can be reached from where it is


class Frontier(Agent):
    """Breadth-first search (lattice.py) on the true map. An upper bound, not a rival."""

    def __init__(self, seed: int, world: Scene):
        super().__init__(seed)
        self.world, self.seed = world, seed
        self.plan: FloorPlan = world.plan
        self.visited: np.ndarray = np.zeros(self.plan.visitable.shape, bool)
        self.episode = -1
        self.way: list[int] = []
        self.wait = 0

    def begin(self) -> None:
        self.way, self.wait = [], 0

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        if info["episode_index"] != self.episode:  # where the things stand today, too
            self.episode = int(info["episode_index"])
            self.plan = self.world.at(self.episode, self.seed)[0].plan
        x, y, yaw = info["pose"]
        self.visited[self.plan.cells(x, y)] = True
        if not self.way and self.wait == 0:
            self.way = self.search(x, y, round(yaw / (2 * np.pi) * HEADINGS) % HEADINGS)
            self.wait = 0 if self.way else PATIENCE
        if self.way:
            return self.way.pop(0)
        self.wait -= 1
        return int(self.rng.integers(len(ACTIONS)))

    def search(self, x: float, y: float, heading: int) -> list[int]:
        """The shortest list of actions that lands on an unvisited cell; [] if there is none."""
        free = self.plan.visitable
        if self.visited[free].all():
            return []
        return Lattice(free, ~self.visited, self.plan.cell).search(x, y, heading)

    def save(self, folder: Path) -> None:
        super().save(folder)
        (folder / "visited.json").write_text(json.dumps(np.flatnonzero(self.visited).tolist()))

    def load(self, folder: Path) -> None:
        super().load(folder)
        self.visited.flat[read_json(folder / "visited.json")] = True
