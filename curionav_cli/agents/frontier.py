"""The oracle with map access: takes the shortest way, in actions, to the nearest cell that it has not visited.

It marks its cell as visited before it acts, so that the cell on which an episode ended counts as unvisited.
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

PATIENCE = 50  # random steps before the next search, once no unvisited cell can be reached


class Frontier(Agent):
    """Searches the true map breadth-first (lattice.py): an upper bound on coverage, not a baseline."""

    def __init__(self, seed: int, scene: Scene):
        super().__init__(seed)
        self.scene, self.seed = scene, seed
        self.plan: FloorPlan = scene.plan
        self.visited: np.ndarray = np.zeros(self.plan.visitable.shape, bool)
        self.episode = -1
        self.way: list[int] = []
        self.wait = 0

    def begin(self) -> None:
        self.way, self.wait = [], 0

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        if info["episode_index"] != self.episode:  # the map with this episode's changes
            self.episode = int(info["episode_index"])
            self.plan = self.scene.at(self.episode, self.seed)[0].plan
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
        """Return the shortest list of actions that ends on an unvisited cell; [] if there is none."""
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
