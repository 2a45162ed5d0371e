"""Which cells are too near to an obstacle for the robot's centre, by where in its cell each return lay.

A cell of the map says only that an obstacle begins somewhere in it, which is half a cell of doubt on either side; the
last return in each cell says where.
"""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.robot.occupancy import INSIDE

ROUNDED = 1e-3  # cells, by which returns may be off, as they are kept in float32


class Clearance:
    """Counts the obstacles within `radius` metres of each cell's centre, cells of `cell` metres.

    point: (rows, columns, 2) float32, the last return in each cell as (row, column) from its centre, in cells.
    count: (rows, columns) int16, occupied cells whose return lies within the radius.
    """

    def __init__(self, shape: tuple[int, int], cell: float, radius: float):
        self.limit = radius / cell
        off = 0.5 + INSIDE / cell  # cells, at most, from a return to the middle of its cell, along either axis
        across = np.arange(-math.floor(self.limit + off), math.floor(self.limit + off) + 1)
        offset = np.stack(np.meshgrid(across, across, indexing="ij"), -1).reshape(-1, 2)
        least = np.hypot(*np.maximum(np.abs(offset) - off, 0.0).T)
        self._offset = offset[least <= self.limit + ROUNDED]  # (K, 2), of all cells that may lie within the radius
        self.point, self.count = np.zeros((*shape, 2), np.float32), np.zeros(shape, np.int16)
        self._held = np.zeros(shape, bool)  # the cells that are counted

    def grow(self, low: tuple[int, int], shape: tuple[int, int]) -> None:
        """Grow to `shape`; what was row 0, column 0 lies at `low` now."""
        margin = [(low[axis], shape[axis] - low[axis] - self.count.shape[axis]) for axis in (0, 1)]
        self.point = np.pad(self.point, [*margin, (0, 0)])
        self.count, self._held = np.pad(self.count, margin), np.pad(self._held, margin)

    def note(self, row: np.ndarray, column: np.ndarray, point: np.ndarray) -> None:
        """Returns lay at `point` (n, 2) of cells (n,), the first of each; `follow` counts those anew."""
        _, first = np.unique(row * self.count.shape[1] + column, return_index=True)
        row, column, point = row[first], column[first], point[first]
        held = self._held[row, column]
        self._add(row[held], column[held], -1)
        self._held[row, column] = False
        self.point[row, column] = point

    def follow(self, occupied: np.ndarray) -> np.ndarray:
        """Count what is occupied now, (rows, columns) bool; the flat indices of cells that came too near to it."""
        changed = np.flatnonzero(self._held != occupied)
        come = occupied.reshape(-1)[changed]
        row, column = np.divmod(changed, occupied.shape[1])
        self._add(row[~come], column[~come], -1)
        near = self._add(row[come], column[come], 1)
        self._held = occupied.copy()
        return near

    def _add(self, row: np.ndarray, column: np.ndarray, change: int) -> np.ndarray:
        """Add `change` to every cell within the radius of the returns in these cells (n,); their flat indices."""
        point = self.point[row, column]
        away = np.hypot(self._offset[:, 0] - point[:, :1], self._offset[:, 1] - point[:, 1:])  # (n, K)
        at, which = np.nonzero(away <= self.limit)
        rows, columns = self.count.shape
        r, c = row[at] + self._offset[which, 0], column[at] + self._offset[which, 1]
        inside = (r >= 0) & (r < rows) & (c >= 0) & (c < columns)
        near = r[inside] * columns + c[inside]
        np.add.at(self.count.reshape(-1), near, np.int16(change))
        return near
