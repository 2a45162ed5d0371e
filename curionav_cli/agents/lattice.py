"""The poses that the three actions lead to, searched breadth-first: the fewest actions to one of some cells.

A pose is a cell and one of 36 headings; of the poses that share both, the first one found stands for all.
"""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.constants import FORWARD, HEADINGS, LEFT, RIGHT, STEP_LENGTH
from curionav_cli.world.motion import COS, SIN, YAW, free_share

EXACT = 1e-9  # radians


class Lattice:
    """free, goal: (rows, columns) bool, cells of `cell` metres whose row 0, column 0 begins at (0, 0).

    further: (rows, columns), actions by which a cell of goal counts as further away than it is; 0 without it.
    turned: radians by which all headings differ from multiples of ten degrees, as those of a robot that drifts.
    reached: cells that the last search looked at, if it found nothing. seen: (rows * columns * HEADINGS,) bool, all
    false, which a caller keeps for the next search; a fresh one costs a millisecond.
    """

    reached = 0

    def __init__(self, free: np.ndarray, goal: np.ndarray, cell: float, turned: float = 0.0,
                 seen: np.ndarray | None = None, further: np.ndarray | None = None):
        self.free, self.goal, self.cell = free, goal, cell
        self.further = np.zeros(goal.shape, np.int16) if further is None else further
        self.seen = np.zeros(free.size * HEADINGS, bool) if seen is None else seen
        exact = abs(turned) < EXACT
        self.cosine: np.ndarray = COS if exact else np.cos(YAW + turned)
        self.sine: np.ndarray = SIN if exact else np.sin(YAW + turned)

    def clear(self, x: float, y: float, heading: int) -> bool:
        """Does a forward move pass through free cells only?"""
        return bool(self.share(np.array([x]), np.array([y]), np.array([heading]))[0] == 1.0)

    def share(self, x: np.ndarray, y: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """(n,) how much of forward moves stays on free cells."""
        dx, dy = STEP_LENGTH * self.cosine[heading], STEP_LENGTH * self.sine[heading]
        return free_share(self.free, self.cell, x, y, dx, dy)

    def search(self, x: float, y: float, heading: int) -> list[int]:
        """The shortest list of actions, with what `further` adds to it, that ends on a cell of `goal` other than by
        staying; [] if there is none.

        A wave of poses (columns x, y, heading) grows by all three actions at once.
        """
        looked: list[np.ndarray] = []
        try:
            way = self._spread(np.array([[x, y, heading]]), looked)
            self.reached = 0 if way or not looked else len(np.unique(np.concatenate(looked) // HEADINGS))
            return way
        finally:
            for place in looked:
                self.seen[place] = False

    def _spread(self, pose: np.ndarray, looked: list[np.ndarray]) -> list[int]:
        """The search from one pose (1, 3); adds the places of every wave to `looked`."""
        waves: list[tuple[np.ndarray, np.ndarray]] = []  # (action, parent's row in the wave before)
        best = (math.inf, 0, 0)
        while len(pose) and len(waves) < best[0]:
            pose, action, parent = self.grow(pose, self.seen)
            place = self.places(pose)
            fresh = np.flatnonzero(~self.seen[place])
            _, first = np.unique(place[fresh], return_index=True)
            first = fresh[np.sort(first)]
            self.seen[place[first]] = True
            looked.append(place[first])
            waves.append((action[first], parent[first]))
            pose, best = pose[first], min(best, self._nearest(place[first] // HEADINGS, len(waves)))
        return trace(waves[:best[1]], best[2])

    def _nearest(self, cell: np.ndarray, wave: int) -> tuple[float, int, int]:
        """Of the cells (n,) of a wave the best goal: (actions with what is added, wave, row); infinite without one."""
        new = np.flatnonzero(self.goal.flat[cell])
        if not len(new):
            return math.inf, 0, 0
        cost = wave + self.further.flat[cell[new]]
        row = int(cost.argmin())
        return float(cost[row]), wave, int(new[row])

    def places(self, pose: np.ndarray) -> np.ndarray:
        """One number for the cell and heading of each pose; poses outside are clipped to the border."""
        rows, columns = self.free.shape
        row = np.clip(np.floor(pose[:, 1] / self.cell).astype(np.int64), 0, rows - 1)
        column = np.clip(np.floor(pose[:, 0] / self.cell).astype(np.int64), 0, columns - 1)
        return (row * columns + column) * HEADINGS + pose[:, 2].astype(np.int64)

    def grow(self, pose: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All poses one action further, with the action and the row they came from.

        A move ahead is looked at closely only where it leads to a free place that was not `seen` yet.
        """
        x, y, heading = pose[:, 0], pose[:, 1], pose[:, 2].astype(np.int64)
        ahead = np.stack([x + STEP_LENGTH * self.cosine[heading], y + STEP_LENGTH * self.sine[heading], heading], 1)
        place = self.places(ahead)
        clear = np.flatnonzero(~seen[place] & self.free.flat[place // HEADINGS])
        clear = clear[self.share(x[clear], y[clear], heading[clear]) == 1.0]
        ahead = ahead[clear]
        left = np.stack([x, y, (heading + 1) % HEADINGS], 1)
        right = np.stack([x, y, (heading - 1) % HEADINGS], 1)
        rows = np.arange(len(pose))
        action = np.repeat([FORWARD, LEFT, RIGHT], [len(clear), len(pose), len(pose)])
        return np.concatenate([ahead, left, right]), action, np.concatenate([clear, rows, rows])


def trace(waves: list[tuple[np.ndarray, np.ndarray]], row: int) -> list[int]:
    """Walk back from a row of the last wave to the start; the actions in the order to take them."""
    actions = []
    for action, parent in reversed(waves):
        actions.append(int(action[row]))
        row = int(parent[row])
    return actions[::-1]
