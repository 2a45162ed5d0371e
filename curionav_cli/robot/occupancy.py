"""An occupancy grid: log-odds of the cells that scans from estimated poses hit or pass through.

It lies in the robot's own frame and grows with its scans; it holds nothing of the true world (Moravec and Elfes 1985,
"High resolution maps from wide angle sonar"; the inverse sensor model is two constants).
"""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.records import Pose
from curionav_cli.robot.measurements import Scan

HIT, MISS, MOST = 0.9, 0.4, 3.5  # log-odds: added for a hit, subtracted for a pass, and their bound
OCCUPIED = 0.5  # log-odds above which a cell is an obstacle
INSIDE = 0.01  # metres behind a return, where the cell that it hit is
MOVED = 0.15  # metres
BLOCK = 40  # cells; the map grows by so many at once


class Occupancy:
    """An occupancy grid in log-odds. odds: (rows, columns) float32 log-odds, 0 where unknown; cell: metres.

    Row 0, column 0 begins at `corner` (x, y) of the robot's own frame. reach: metres beyond which returns are not used.
    SAVED: the names of its arrays.
    """

    SAVED = ("odds", "corner", "entered")

    def __init__(self, cell: float = 0.1, reach: float = 6.0):
        self.cell, self.reach = cell, reach
        self.odds = np.zeros((2 * BLOCK, 2 * BLOCK), np.float32)
        self.corner: tuple[float, float] = (-BLOCK * cell, -BLOCK * cell)
        self._inserted = (math.inf, math.inf)
        self._along = np.arange(0.0, reach, cell)  # (S,)

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray], cell: float = 0.1, reach: float = 6.0) -> Occupancy:
        """Restore a grid from the arrays of `save`."""
        grid = cls(cell, reach)
        grid.odds = arrays["odds"]
        grid.corner, grid._inserted = tuple(arrays["corner"].tolist()), tuple(arrays["entered"].tolist())
        return grid

    def save(self) -> dict[str, np.ndarray]:
        """The arrays that `of` restores, by the names in SAVED."""
        return {"odds": self.odds, "corner": np.array(self.corner), "entered": np.array(self._inserted)}

    @property
    def occupied(self) -> np.ndarray:
        """(rows, columns) bool: log-odds above OCCUPIED."""
        return self.odds > OCCUPIED

    @property
    def known(self) -> np.ndarray:
        """(rows, columns) bool: hit or passed at least once."""
        return self.odds != 0.0

    def cells(self, x, y) -> tuple[np.ndarray, np.ndarray]:
        """(row, column) of positions in metres; outside the map they are negative or too large."""
        column = np.floor((np.asarray(x) - self.corner[0]) / self.cell).astype(np.int64)
        return np.floor((np.asarray(y) - self.corner[1]) / self.cell).astype(np.int64), column

    def insert(self, pose: Pose, scan: Scan, near: float = 0.0) -> None:
        """Insert a scan taken at an estimated pose: each cell at most once as free and once as hit.

        near: metres within which the sensor does not see the floor, so that nothing is marked free there.
        """
        seen = np.isfinite(scan.range)
        length = np.minimum(scan.range[seen], self.reach)
        angle = scan.bearing[seen] + pose[2]
        cosine, sine = np.cos(angle), np.sin(angle)
        ends = length < self.reach
        self._grow(pose[0], pose[1])
        self._inserted = (pose[0], pose[1])
        free = (self._along >= near) & (self._along < length[:, None] - 0.5 * self.cell)  # (A, S)
        x = (pose[0] + cosine[:, None] * self._along)[free]
        y = (pose[1] + sine[:, None] * self._along)[free]
        self._add(x, y, -MISS)
        past = length[ends] + INSIDE
        self._add(pose[0] + cosine[ends] * past, pose[1] + sine[ends] * past, HIT + MISS)

    def integrate_scan(self, pose: Pose, scan: Scan) -> None:
        """Insert a scan, unless the last one was taken within MOVED metres: a turn on the spot adds little."""
        if math.hypot(pose[0] - self._inserted[0], pose[1] - self._inserted[1]) > MOVED:
            self.insert(pose, scan)

    def mark_occupied(self, x: float, y: float) -> None:
        """Mark the cell at (x, y), metres, as occupied after a bump."""
        self._add(np.array([x]), np.array([y]), MOST + HIT)

    def clear(self, x: float, y: float, radius: float) -> None:
        """Set the cells within `radius` metres of (x, y) to unknown."""
        self.odds[self.cells_within(x, y, radius)] = 0.0

    def cells_within(self, x: float, y: float, radius: float) -> np.ndarray:
        """(rows, columns) bool: cells whose centre is within `radius` metres of (x, y)."""
        rows, columns = self.odds.shape
        away_x = self.corner[0] + (np.arange(columns) + 0.5) * self.cell - x
        away_y = self.corner[1] + (np.arange(rows) + 0.5) * self.cell - y
        return np.hypot(away_x[None, :], away_y[:, None]) < radius

    def _add(self, x: np.ndarray, y: np.ndarray, change: float) -> None:
        row, column = self.cells(x, y)
        flat, index = self.odds.reshape(-1), row * self.odds.shape[1] + column
        flat[index] = np.clip(flat[index] + np.float32(change), -MOST, MOST)

    def _grow(self, x: float, y: float) -> None:
        """Grow until a scan at (x, y) fits."""
        rows, columns = self.odds.shape
        room = self.reach + 2 * self.cell
        left, below = self.corner[0] - (x - room), self.corner[1] - (y - room)
        right, above = (x + room) - self.corner[0] - columns * self.cell, (y + room) - self.corner[1] - rows * self.cell
        blocks = [max(0, math.ceil(missing / (BLOCK * self.cell))) * BLOCK for missing in (below, above, left, right)]
        if any(blocks):
            self.odds = np.pad(self.odds, (blocks[:2], blocks[2:]))
            self.corner = (self.corner[0] - blocks[2] * self.cell, self.corner[1] - blocks[0] * self.cell)
