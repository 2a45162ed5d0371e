"""The robot's map with surprise on it: how surprised the world model was by the views that show a place.

A place is a cell. A view is ascribed to the cell it was taken from and to those that its depth image shows, floor and
the front of obstacles, within `sight` metres. A cell remembers the running mean of its views: all of the first ten
count alike, older ones then fade.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.agents.curious_mapper.levels import Levels
from curionav_cli.agents.mapper.memory import Memory
from curionav_cli.records import Pose
from curionav_cli.robot.measurements import Scan

RAYS = 4  # of the image's columns every fourth is followed
LEAST = 0.1  # of what first sights have, that a place where the robot has not stood is worth at least
VIEWS = 10.0  # of a cell, after which new ones count for a tenth


class SurpriseMemory(Memory):
    """A Memory with four more grids, (rows, columns) each.

    surprise: float32 nats, of the views that show the cell; shown: float32, how many views that is, at most VIEWS;
    episode: int32, the number of the last one that showed it, from 1; stood: int32, steps that ended there.
    measured: the surprise of the view that is being entered, None for none.
    """

    surprise: np.ndarray
    shown: np.ndarray
    episode: np.ndarray
    stood: np.ndarray
    measured: float | None = None

    GRIDS = (*Memory.GRIDS, "surprise", "shown", "episode", "stood")
    SAVED = (*Memory.SAVED, "surprise", "shown", "episode", "stood", "number", *Levels.SAVED)

    def __init__(self, cell: float, reach: float, radius: float, sight: float, optimism: float):
        super().__init__(cell, reach, radius)
        for name, kind in zip(self.GRIDS[-4:], (np.float32, np.float32, np.int32, np.int32), strict=True):
            setattr(self, name, np.zeros(self.map.odds.shape, kind))
        self.levels, self.number = Levels(optimism), 1
        self._sight = np.arange(0.0, sight, cell)
        self._view: tuple[Pose, Scan] | None = None

    def begin(self) -> None:
        """An episode begins: what the last one showed has been learned since. Twice in a row changes nothing more.

        What was measured before the model had learned anything, in the first episode, is forgotten.
        """
        super().begin()
        newest = self.episode == self.number
        if not newest.any():
            return
        if self.number == 1:
            self.shown[:], self.levels = 0.0, Levels(self.levels.optimism)
        self.surprise[newest] *= np.float32(self.levels.end_of_episode())
        self.shown = np.minimum(self.shown, np.float32(1.0))
        self.number += 1

    def see(self, pose: Pose, scan: Scan, near: float, lidar: Scan | None = None) -> None:
        super().see(pose, scan, near, lidar)
        self._view = pose, scan

    def land(self, x: float, y: float, begun: tuple[float, float]) -> None:
        at = self.map.cells(x, y)
        first = not self.visited[at]
        super().land(x, y, begun)
        self.stood[at] += 1
        if self.measured is not None and self._view:
            if first:
                self.levels.add_first(self.measured)
            self.enter(self.measured, *self._view)

    def enter(self, surprise: float, pose: Pose, scan: Scan) -> None:
        """Ascribe a view's surprise to the cells that it shows, and to the one that it was taken from."""
        cells = self.cells_of(pose, scan)
        again = cells[(self.shown.flat[cells] > 0) & (self.episode.flat[cells] < self.number)]
        if len(again):
            self.levels.met_again(float(self.surprise.flat[again].mean()), surprise)
        views = np.minimum(self.shown.flat[cells] + 1.0, VIEWS)
        self.surprise.flat[cells] += (np.float32(surprise) - self.surprise.flat[cells]) / views
        self.shown.flat[cells], self.episode.flat[cells] = views, self.number

    def cells_of(self, pose: Pose, scan: Scan) -> np.ndarray:
        """(n,) flat indices, each once: the cell of the pose, and those along the rays up to what they hit."""
        angle, length = scan.bearing[::RAYS] + pose.yaw, scan.range[::RAYS]
        far = np.minimum(self._sight, length[:, None] + 0.01)  # (A, S); a hit lies just inside what was hit
        x, y = pose.x + np.cos(angle)[:, None] * far, pose.y + np.sin(angle)[:, None] * far
        row, column = self.map.cells(x, y)
        return np.unique(row * self.map.odds.shape[1] + column)

    def worth_of_surprise(self) -> np.ndarray:
        """(rows, columns) float32 nats above the usual that a visit is expected to bring; 0 where it was today.

        Where the robot has stood: what is remembered. Where it has not: what first sights have, more or less by what
        views from elsewhere had. Either difference is taken for as much as the map's differences were found again.
        """
        levels = self.levels
        known = levels.trust * np.maximum(self.surprise - levels.usual, 0.0)
        first = levels.expected - levels.usual
        seen = first + levels.trust * (self.surprise - levels.remembered)
        new = np.where(self.shown > 0, np.maximum(seen, LEAST * first), first)
        return np.where(self.today, 0.0, np.where(self.visited, known, new)).astype(np.float32)

    def worth_of_visits(self) -> np.ndarray:
        """(rows, columns) float32: one over the root of the steps that ended there; 0 where it was today."""
        return np.where(self.today, 0.0, 1.0 / np.sqrt(1.0 + self.stood)).astype(np.float32)

    def save(self) -> dict[str, np.ndarray]:
        return super().save() | self.levels.save() | {"number": np.array(self.number)}

    def load(self, arrays: dict[str, np.ndarray]) -> None:
        super().load(arrays)
        self.levels.load(arrays)
        self.number = int(arrays["number"])
