"""An oracle that is told the map: the shortest way, in actions, to the nearest cell not yet landed on.

It looks where it is before it acts, so that the cell on which an episode ended stays new to it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.agents.agent import Agent
from curionav_cli.files import read_json
from curionav_cli.records import FloorPlan
from curionav_cli.world.motion import COS, FORWARD, HEADINGS, LEFT, RIGHT, SIN, STEP, forward_clear
from curionav_cli.world.scene import Scene

PATIENCE = 50  # random steps before it searches again, once no new cell can be reached from where it is


class Frontier(Agent):
    """Breadth-first search over (cell, heading) with the world's own motion. An upper bound, not a rival."""

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
        if info["episode_index"] != self.episode:  # it is told where the things stand today, too
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
        return int(self.rng.integers(3))

    def search(self, x: float, y: float, heading: int) -> list[int]:
        """The shortest list of actions that lands on an unvisited cell; [] if there is none.

        A wave of poses (columns x, y, heading) grows by all three actions at once; of the poses that
        share a cell and a heading the first is kept.
        """
        if self.visited[self.plan.visitable].all():
            return []
        pose = np.array([[x, y, heading]])
        seen = np.zeros(self.visited.size * HEADINGS, bool)
        waves: list[tuple[np.ndarray, np.ndarray]] = []  # (action, parent's row in the wave before)
        while len(pose):
            pose, action, parent = self.grow(pose, seen)
            place = self.places(pose)
            fresh = np.flatnonzero(~seen[place])
            _, first = np.unique(place[fresh], return_index=True)
            first = fresh[np.sort(first)]
            seen[place[first]] = True
            waves.append((action[first], parent[first]))
            pose, new = pose[first], np.flatnonzero(~self.visited.flat[place[first] // HEADINGS])
            if len(new):
                return trace(waves, int(new[0]))
        return []

    def places(self, pose: np.ndarray) -> np.ndarray:
        """One number for the cell and heading of each pose."""
        row, column = self.plan.cells(pose[:, 0], pose[:, 1])
        return (row * self.visited.shape[1] + column) * HEADINGS + pose[:, 2].astype(np.int64)

    def grow(self, pose: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All poses one action further, with the action and the row they came from.

        A move ahead is looked at closely only where it leads to a free place that was not `seen` yet.
        """
        x, y, heading = pose[:, 0], pose[:, 1], pose[:, 2].astype(np.int64)
        ahead = np.stack([x + STEP * COS[heading], y + STEP * SIN[heading], heading], 1)
        place = self.places(ahead)
        clear = np.flatnonzero(~seen[place] & self.plan.visitable.flat[place // HEADINGS])
        clear = clear[forward_clear(self.plan.visitable, self.plan.cell, x[clear], y[clear], heading[clear])]
        ahead = ahead[clear]
        left = np.stack([x, y, (heading + 1) % HEADINGS], 1)
        right = np.stack([x, y, (heading - 1) % HEADINGS], 1)
        rows = np.arange(len(pose))
        action = np.repeat([FORWARD, LEFT, RIGHT], [len(clear), len(pose), len(pose)])
        return np.concatenate([ahead, left, right]), action, np.concatenate([clear, rows, rows])

    def save(self, folder: Path) -> None:
        super().save(folder)
        (folder / "visited.json").write_text(json.dumps(np.flatnonzero(self.visited).tolist()))

    def load(self, folder: Path) -> None:
        super().load(folder)
        self.visited.flat[read_json(folder / "visited.json")] = True


def trace(waves: list[tuple[np.ndarray, np.ndarray]], row: int) -> list[int]:
    """Walk back from a row of the last wave to the start; the actions in the order to take them."""
    actions = []
    for action, parent in reversed(waves):
        actions.append(int(action[row]))
        row = int(parent[row])
    return actions[::-1]
