"""The poses that the three actions lead to, searched breadth-first: the fewest actions to one of some cells.

A pose is a cell and one of 36 headings; of the poses that share both, the first one found stands for all. A wave of the
search is done by lattice_numpy.py, or by lattice_numba.py (`grower` says when): the same to the bit.
"""

from __future__ import annotations

import logging
import math
import sys
from collections.abc import Callable, Generator
from contextlib import closing
from functools import cache
from typing import ClassVar

import cv2
import numpy as np

from curionav_cli.agents import lattice_numpy
from curionav_cli.constants import HEADINGS, STEP_LENGTH
from curionav_cli.world.motion import COS, SIN, YAW, moved

log = logging.getLogger("curionav")

EXACT = 1e-9  # radians
PAYS = 2_500_000  # poses; to load numba takes as long (0.9 CPU-s) as numpy takes for so many
Links = list[tuple[np.ndarray, np.ndarray]]  # of each wave: (action, parent's row in the wave before)


class Lattice:
    """free, goal: (rows, columns) bool, cells of `cell` metres whose row 0, column 0 begins at (0, 0).

    further: (rows, columns), actions by which a cell of goal counts as further away than it is; 0 without it.
    turned: radians by which all headings differ from multiples of ten degrees, as those of a robot that drifts.
    reached: cells that the last search looked at, if it found nothing. seen: (rows * columns * HEADINGS,) bool, all
    false, which a caller keeps for the next search; a fresh one costs a millisecond. searched: poses that were found by
    this process so far.
    """

    reached = 0
    searched: ClassVar[int] = 0

    def __init__(self, free: np.ndarray, goal: np.ndarray, cell: float, turned: float = 0.0,
                 seen: np.ndarray | None = None, further: np.ndarray | None = None):
        self.free, self.goal, self.cell = free, goal, cell
        self.further = np.zeros(goal.shape, np.int16) if further is None else further
        self.seen = np.zeros(free.size * HEADINGS, bool) if seen is None else seen
        exact = abs(turned) < EXACT
        self.dx: np.ndarray = STEP_LENGTH * (COS if exact else np.cos(YAW + turned))
        self.dy: np.ndarray = STEP_LENGTH * (SIN if exact else np.sin(YAW + turned))

    def clear(self, x: float, y: float, heading: int) -> bool:
        """Does a forward move pass through free cells only?"""
        return not moved(self.free, self.cell, x, y, float(self.dx[heading]), float(self.dy[heading]))[2]

    def search(self, x: float, y: float, heading: int) -> list[int]:
        """The shortest list of actions, with what `further` adds to it, that ends on a cell of `goal` other than by
        staying; [] if there is none."""
        links: Links = []
        best, least = (math.inf, 0, 0), -1
        with closing(self.spread(x, y, heading, links)) as waves:
            for cell in waves:
                best = min(best, self._nearest(cell, len(links)))
                if least < 0 and len(links) + 1 < best[0] < math.inf:
                    least = self._least(x, y)
                if len(links) + 1 + max(least, 0) >= best[0]:
                    break
        return trace(links[:best[1]], best[2])

    def spread(self, x: float, y: float, heading: int, links: Links) -> Generator[np.ndarray]:
        """The cells (n,), flat indices, of poses that are one action away, two, ... from one; adds to `links`.

        To be closed when enough was seen. If it ends by itself, `reached` is set.
        """
        pose, looked = np.array([[x, y, heading]], np.float64), []
        place = self._place(x, y, heading)
        self.reached, wave = 0, grower(Lattice.searched)(self.free, self.seen, self.cell, self.dx, self.dy)
        try:
            while len(pose):
                pose, place, action, parent = wave(pose, place)
                looked.append(place)
                links.append((action, parent))
                yield place // HEADINGS
            self.reached = int(self.seen.reshape(-1, HEADINGS).any(1).sum())
        finally:
            for place in looked:
                self.seen[place] = False
                Lattice.searched += len(place)

    def _place(self, x: float, y: float, heading: int) -> np.ndarray:
        """(1,) the place of a pose."""
        return lattice_numpy.places(np.array([x]), np.array([y]), heading, self.free.shape, self.cell)

    def _nearest(self, cell: np.ndarray, actions: int) -> tuple[float, int, int]:
        """Of the cells (n,) of a wave the best goal: (actions with what is added, wave, row); infinite without one."""
        new = np.flatnonzero(self.goal.reshape(-1)[cell])
        if not len(new):
            return math.inf, 0, 0
        cost = actions + self.further.reshape(-1)[cell[new]]
        row = int(cost.argmin())
        return float(cost[row]), actions, int(new[row])

    def _least(self, x: float, y: float) -> int:
        """The least that `further` adds to a cell of `goal` that hangs together with (x, y): a bound on all that the
        search can find."""
        at = self._place(x, y, 0)[0] // HEADINGS
        passable = self.free.astype(np.uint8)
        passable.flat[at] = 1
        _, label = cv2.connectedComponents(passable, connectivity=8)
        return int(self.further[self.goal & (label == label.flat[at])].min(initial=np.iinfo(np.int16).max))


def grower(searched: int) -> Callable[..., Callable[..., lattice_numpy.Found]]:
    """What does the waves of a search, once this process has found so many poses.

    numba's code where it is installed (the extra `fast`) and either loaded already, as by env.engine=numba, or worth
    loading; else numpy's.
    """
    return _compiled() if searched > PAYS or "numba" in sys.modules else lattice_numpy.Waves


@cache
def _compiled() -> Callable[..., Callable[..., lattice_numpy.Found]]:
    try:
        from curionav_cli.agents.lattice_numba import Waves
    except ImportError:
        log.info("Ways are searched by numpy; with the extra `fast` the same ones are found in half the time.")
        return lattice_numpy.Waves
    log.info("Ways are searched by numba from here on, which chooses the same ones as numpy.")
    return Waves


def trace(links: Links, row: int) -> list[int]:
    """Walk back from a row of the last wave to the start; the actions in the order to take them."""
    actions = []
    for action, parent in reversed(links):
        actions.append(int(action[row]))
        row = int(parent[row])
    return actions[::-1]
