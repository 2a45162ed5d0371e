"""The robot's memory of a place, kept across episodes: its occupancy map, and the cells that it visited.

All arrays lie on the occupancy's grid and grow with it. Obstacles fade: the map's log-odds fall where the camera sees
the floor again, and a cell that a cancelled move closed opens when nothing is near it any more.
"""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.agents.mapper.clearance import Clearance
from curionav_cli.constants import STEP_LENGTH
from curionav_cli.records import Pose
from curionav_cli.robot.measurements import Scan
from curionav_cli.robot.occupancy import INSIDE, MOST, OCCUPIED, Occupancy

MOVED, TURNED = 0.2, math.radians(25.0)  # a view is entered when the robot moved or turned so much since the last one
FADED = 1.0  # log-odds, at most, of an obstacle when an episode begins: two views of the floor there open the cell
SHUT_IN = 1.0  # metres around a robot that is shut in, within which it forgets obstacles
ALONG = np.arange(1, 11) / 10.0  # of a move, to find the cells that it passes


class Memory:
    """Occupancy and visits on one grid, (rows, columns) bool each.

    visited: cells landed on, ever; today: in this episode; passed: cells that a move went through; closed: cells that
    stopped a move. blocked: (rows, columns) int16, how many episodes ended with the cell not free.
    cell, reach, radius in metres: of the grid, of what is entered of a view, of the robot.
    """

    visited: np.ndarray
    today: np.ndarray
    passed: np.ndarray
    closed: np.ndarray
    blocked: np.ndarray

    GRIDS: tuple[str, ...] = ("visited", "today", "passed", "closed", "blocked")
    SAVED: tuple[str, ...] = (*Occupancy.SAVED, "visited", "today", "passed", "closed")
    LATER: tuple[str, ...] = ("blocked", "point")  # runs of earlier versions do not record them

    def __init__(self, cell: float, reach: float, radius: float):
        self.map, self.radius = Occupancy(cell, reach), radius
        for name in self.GRIDS:
            setattr(self, name, np.zeros(self.map.odds.shape, np.int16 if name == "blocked" else bool))
        self.clearance = Clearance(self.map.odds.shape, cell, radius)
        self._corner = self.map.corner
        self._free: np.ndarray | None = None
        self._entered = (math.inf, math.inf, 0.0)
        self._core, self._around = disc(radius / 2 / cell), disc(radius / cell + 2)

    @property
    def cell(self) -> float:
        return self.map.cell

    def begin(self) -> None:
        """An episode begins: things may have moved, so obstacles fade, and the next view counts. Twice in a row changes
        nothing more."""
        if self.today.any():
            self.blocked += ~self.free
        self.today[:] = False
        np.minimum(self.map.odds, np.float32(FADED), out=self.map.odds)
        self._entered = (math.inf, math.inf, 0.0)

    def see(self, pose: Pose, scan: Scan, near: float, lidar: Scan | None = None) -> None:
        """Enter a view, unless it is nearly the last one. near: metres within which the floor is not seen.

        lidar: what a LiDAR on the floor sees from there, if the robot has one.
        """
        x, y, yaw = self._entered
        turned = abs((pose.yaw - yaw + math.pi) % (2 * math.pi) - math.pi)
        if math.hypot(pose.x - x, pose.y - y) < MOVED and turned < TURNED:
            return
        self._entered = pose
        self._enter(pose, scan, near)
        if lidar:
            self._enter(pose, lidar, 0.0)
        self._follow()

    def _enter(self, pose: Pose, scan: Scan, near: float) -> None:
        self.map.insert(pose, scan, near)
        if self.visited.shape != self.map.odds.shape:
            self._grow()
        self._note(pose, scan)

    def _note(self, pose: Pose, scan: Scan) -> None:
        """Keep where in their cells the returns of a view lay."""
        hit = scan.range < self.map.reach
        angle = scan.bearing[hit] + pose.yaw
        along = np.stack([np.sin(angle), np.cos(angle)], 1)  # (n, 2) row, column
        at = (along * scan.range[hit, None] + (pose.y - self.map.corner[1], pose.x - self.map.corner[0])) / self.cell
        cell = np.floor(at + along * (INSIDE / self.cell)).astype(np.int64)
        self.clearance.note(cell[:, 0], cell[:, 1], at - cell - 0.5)

    def _follow(self) -> None:
        """Obstacles changed: what came within the robot's radius of cells that moves went through closes them."""
        self.passed.reshape(-1)[self.clearance.follow(self.map.occupied)] = False
        self._free = None

    def land(self, x: float, y: float, begun: tuple[float, float]) -> None:
        """A step that began at `begun` has ended at (x, y), and nothing stood in between."""
        at = self.map.cells(x, y)
        self.visited[at], self.today[at] = True, True
        row, column = self.map.cells(begun[0] + ALONG * (x - begun[0]), begun[1] + ALONG * (y - begun[1]))
        if self.closed[row, column].any():
            self.closed[row, column], self._free = False, None
        self.passed[row, column] = True

    def cancelled(self, x: float, y: float, yaw: float) -> None:
        """A move from (x, y) was cancelled: of the cells on its way, beyond its own, the likeliest is closed.

        That is one that no move went through yet, if there is one, and of those the one nearest to an obstacle. Where
        no obstacle is known nearby, there is one now.
        """
        row, column = self.map.cells(x + ALONG * STEP_LENGTH * math.cos(yaw), y + ALONG * STEP_LENGTH * math.sin(yaw))
        here = self.map.cells(x, y)
        beyond = (row != here[0]) | (column != here[1])  # the robot stands on its own cell, so that one is free
        if not beyond.any():
            return
        row, column = row[beyond], column[beyond]
        room = self.room(row, column)
        worst = int(np.argmin(room + MOST * self.passed[row, column]))
        self.closed[row[worst], column[worst]] = True
        if room[worst] > self.radius + 2 * self.cell:
            self.map.odds[row[worst], column[worst]] = MOST
        self._follow()

    def forget(self, x: float, y: float) -> None:
        """Forget the obstacles around (x, y), to look at them again."""
        around = self.map.cells_within(x, y, SHUT_IN)
        self.map.odds[around & self.map.occupied] = 0.0
        self.closed[around] = False
        self._entered = (math.inf, math.inf, 0.0)
        self._follow()

    def room(self, row: np.ndarray, column: np.ndarray) -> np.ndarray:
        """(n,) metres from cells (n,) to the nearest occupied one, of those within a metre of the first cell."""
        span = round(1.0 / self.cell)
        low = max(0, int(row[0]) - span), max(0, int(column[0]) - span)
        part = self.map.occupied[low[0]:row[0] + span, low[1]:column[0] + span]
        at = np.argwhere(part) + low  # (m, 2)
        away = np.hypot(row[:, None] - at[:, 0], column[:, None] - at[:, 1])
        return away.min(axis=1, initial=2.0 * span) * self.cell

    @property
    def free(self) -> np.ndarray:
        """(rows, columns) bool: where the robot's centre may be. What is unknown is free until it is seen."""
        if self._free is None:
            free = self.clearance.count == 0
            tight, closed = np.flatnonzero(self.passed > free), np.flatnonzero(self.closed)
            free.flat[tight] = ~self._beside(tight, self._core)
            free.flat[closed[self._beside(closed, self._around)]] = False
            self._free = free
        return self._free

    def _beside(self, cells: np.ndarray, disc: np.ndarray) -> np.ndarray:
        """(n,) bool: does an occupied cell lie within a disc (K, 2) around these cells, flat indices (n,)?"""
        rows, columns = self.map.odds.shape
        at = np.divmod(cells, columns)
        row = np.minimum(np.maximum(at[0][:, None] + disc[:, 0], 0), rows - 1)  # (n, K)
        column = np.minimum(np.maximum(at[1][:, None] + disc[:, 1], 0), columns - 1)
        return (self.map.odds.reshape(-1)[row * columns + column] > OCCUPIED).any(axis=1)

    def _grow(self) -> None:
        row, column = (round((self._corner[axis] - self.map.corner[axis]) / self.cell) for axis in (1, 0))
        for name in self.GRIDS:
            old = getattr(self, name)
            new = np.zeros(self.map.odds.shape, old.dtype)
            new[row:row + old.shape[0], column:column + old.shape[1]] = old
            setattr(self, name, new)
        self.clearance.grow((row, column), self.map.odds.shape)
        self._corner = self.map.corner

    def save(self) -> dict[str, np.ndarray]:
        """All that `load` needs after an episode, as arrays."""
        return self.map.save() | {name: getattr(self, name) for name in self.GRIDS} | {"point": self.clearance.point}

    def load(self, arrays: dict[str, np.ndarray]) -> None:
        """What `save` gave. Without LATER nothing was blocked before, and returns lay in the middle of their cells."""
        cell, reach = self.map.cell, self.map.reach
        self.map = Occupancy.of(arrays, cell, reach)
        shape = self.map.odds.shape
        blocked, point = np.zeros(shape, np.int16), np.zeros((*shape, 2), np.float32)
        arrays = {"blocked": blocked, "point": point, **arrays}
        for name in self.GRIDS:
            setattr(self, name, arrays[name])
        self.clearance = Clearance(self.map.odds.shape, cell, self.radius)
        self.clearance.point = arrays["point"]
        self.clearance.follow(self.map.occupied)
        self._corner = self.map.corner
        self._free = None


def disc(radius: float) -> np.ndarray:
    """(K, 2) offsets (row, column) of the cells whose centre is within `radius` cells of the middle one's."""
    most = max(0, math.floor(radius))
    across = np.arange(-most, most + 1)
    return np.argwhere(np.hypot(across[:, None], across) <= radius) - most
