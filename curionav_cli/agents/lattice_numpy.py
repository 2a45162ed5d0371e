"""The waves of a search over poses (lattice.py), by numpy."""

from __future__ import annotations

import math
from functools import cached_property

import cv2
import numpy as np

from curionav_cli.constants import FORWARD, HEADINGS, LEFT, RIGHT
from curionav_cli.world.motion import free_share, moved

FEW = 6  # poses; one by one they take less time than all at once
MANY = 200  # moves; for more it pays to find where all cells around are free
ROUNDED = 1e-6  # cells, by which sums of numbers may be off
TO_LEFT = np.roll(np.arange(HEADINGS), -1) - np.arange(HEADINGS)  # what a turn adds to a place, by its heading
TO_RIGHT = np.roll(np.arange(HEADINGS), 1) - np.arange(HEADINGS)
Found = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
Part = tuple[np.ndarray, np.ndarray, np.ndarray]  # poses (m, 3), places (m,), rows that they came from (m,)


class Waves:
    """What a search calls for each wave: all new poses one action further than some.

    free: (rows, columns) bool, cells of `cell` metres; seen: (rows * columns * HEADINGS,) bool, by `places`, in which
    new poses are noted; dx, dy: (HEADINGS,) metres of a move.
    """

    def __init__(self, free: np.ndarray, seen: np.ndarray, cell: float, dx: np.ndarray, dy: np.ndarray):
        self.free, self.seen, self.cell, self.dx, self.dy = free, seen, cell, dx, dy

    def __call__(self, pose: np.ndarray, place: np.ndarray) -> Found:
        """From poses (n, 3), columns x, y, heading, and their places (n,), no two alike: poses (m, 3), their places
        (m,), the actions that led there (m,) and the rows they came from (m,).

        Moves ahead first, then turns to the left, then to the right; of poses that share a place the first stays.
        """
        if len(pose) <= FEW:
            return self._one_by_one(pose.tolist(), place.tolist())
        heading = pose[:, 2].astype(np.int64)
        parts = [self._ahead(pose, place, heading), self._turned(pose, place, TO_LEFT[heading]),
                 self._turned(pose, place, TO_RIGHT[heading])]
        action = np.repeat([FORWARD, LEFT, RIGHT], [len(found) for found, _, _ in parts])
        found, places, parent = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        return found, places, action, parent

    @cached_property
    def _wide(self) -> np.ndarray:
        """(HEADINGS * rows * columns,) bool: is a move from this cell clear because all cells that one with this
        heading could pass are free?"""
        free = self.free.astype(np.uint8)
        moves = np.stack([self.dx, self.dy], 1) / self.cell
        return np.stack([clear_of(free, *move) for move in moves.tolist()]).reshape(-1).view(bool)

    def _one_by_one(self, pose: list[list[float]], place: list[int]) -> Found:
        """The same for a few poses."""
        found: list[tuple[float, float, float]] = []
        links: list[tuple[int, int, int]] = []  # place, action, parent
        for action in (FORWARD, LEFT, RIGHT):
            for parent, (x, y, towards) in enumerate(pose):
                heading = int(towards)
                if action == FORWARD:
                    move = float(self.dx[heading]), float(self.dy[heading])
                    there = self._place(x + move[0], y + move[1], heading)
                    if self.seen[there] or moved(self.free, self.cell, x, y, *move)[2]:
                        continue
                    x, y = x + move[0], y + move[1]
                else:
                    there = place[parent] + int((TO_LEFT if action == LEFT else TO_RIGHT)[heading])
                    towards = float(there % HEADINGS)
                    if self.seen[there]:
                        continue
                self.seen[there] = True
                found.append((x, y, towards))
                links.append((there, action, parent))
        columns = np.array(links, np.int64).reshape(-1, 3).T
        return np.array(found, np.float64).reshape(-1, 3), columns[0], columns[1], columns[2]

    def _place(self, x: float, y: float, heading: int) -> int:
        """`places` of one pose."""
        rows, columns = self.free.shape
        row = min(max(math.floor(y / self.cell), 0), rows - 1)
        return (row * columns + min(max(math.floor(x / self.cell), 0), columns - 1)) * HEADINGS + heading

    def _ahead(self, pose: np.ndarray, at: np.ndarray, heading: np.ndarray) -> Part:
        """The new poses of moves from places (n,); looks closely only at those that lead to a free place."""
        x, y = pose[:, 0] + self.dx[heading], pose[:, 1] + self.dy[heading]
        place = places(x, y, heading, self.free.shape, self.cell)
        new = (~self.seen[place] & self.free.reshape(-1)[place // HEADINGS]).nonzero()[0]
        new = first_of_each(place, new[self._clear(pose[new], at[new], heading[new])])
        there, found = place[new], pose[new]
        self.seen[there] = True
        found[:, 0], found[:, 1] = x[new], y[new]
        return found, there, new

    def _clear(self, pose: np.ndarray, place: np.ndarray, heading: np.ndarray) -> np.ndarray:
        """(n,) bool: do moves from these poses pass through free cells only?"""
        clear = np.zeros(len(pose), bool)
        if len(pose) > MANY:
            clear = self._wide[heading * self.free.size + place // HEADINGS]
        close = (~clear).nonzero()[0]
        x, y, towards = pose[close, 0], pose[close, 1], heading[close]
        clear[close] = free_share(self.free, self.cell, x, y, self.dx[towards], self.dy[towards]) == 1.0
        return clear

    def _turned(self, pose: np.ndarray, place: np.ndarray, to_side: np.ndarray) -> Part:
        """The new poses of turns, which add `to_side` (n,) to places (n,). No two turns to one side share a place, as
        no two poses do."""
        there = place + to_side
        new = (~self.seen[there]).nonzero()[0]
        there = there[new]
        self.seen[there] = True
        found = pose[new]
        found[:, 2] = there % HEADINGS
        return found, there, new


def places(x: np.ndarray, y: np.ndarray, heading: np.ndarray | int, shape: tuple[int, ...], cell: float) -> np.ndarray:
    """(n,) one number for the cell and heading of each pose; poses outside are clipped to the border."""
    rows, columns = shape
    row = np.minimum(np.maximum(np.floor(y / cell).astype(np.int64), 0), rows - 1)
    column = np.minimum(np.maximum(np.floor(x / cell).astype(np.int64), 0), columns - 1)
    return (row * columns + column) * HEADINGS + heading


def clear_of(free: np.ndarray, across: float, up: float) -> np.ndarray:
    """Of free (rows, columns) uint8 the cells from which a move by (across, up), in cells, passes free ones only,
    wherever in the cell it begins: all that lie in the rectangle that it could touch."""
    right, above = int(abs(across) + ROUNDED) + 1, int(abs(up) + ROUNDED) + 1
    anchor = (0 if across >= 0 else right, 0 if up >= 0 else above)
    return cv2.erode(free, np.ones((above + 1, right + 1), np.uint8), anchor=anchor, borderType=cv2.BORDER_CONSTANT,
                     borderValue=0)


def first_of_each(place: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Of rows (n,), ascending, the first of each place, ascending; place (N,), not negative."""
    key = np.sort(place[rows] * len(place) + rows)  # numbers are sorted many times as fast as np.unique argsorts them
    held, row = np.divmod(key, len(place))
    return np.sort(row[np.append(True, held[1:] != held[:-1])[:len(row)]])
