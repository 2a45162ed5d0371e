"""Shortest paths on an occupancy grid, from every cell to one goal (Dijkstra's algorithm from the goal outwards).

One search gives the cost to go of every cell, so the local layer compares headings and a blocked robot replans without
another search. The grid is 8-connected; cells nearer to an obstacle than BODY are closed, those nearer than INFLATION
cost more, unknown ones are passable at a price. The Occupancy is the planner's only input.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from curionav_cli.robot.occupancy import Occupancy

BODY = 0.15  # metres; an obstacle in a cell is somewhere in it, so a little less than the robot's radius
INFLATION = 0.24  # metres
CLOSE, UNKNOWN, TIGHT = 6.0, 3.0, 30.0  # cost of a metre inside the inflation, in unknown cells, and on the way out
OUT = 0.3  # metres around a robot that stands too near to an obstacle, within which closed cells are passable
BORDER = 4  # cells around the known ones, through which a path may lead
NEIGHBOURS = ((0, 1, 1.0), (1, 0, 1.0), (1, 1, 2.0 ** 0.5), (1, -1, 2.0 ** 0.5))


@dataclass(frozen=True)
class Plan:
    """A plan. cost: (rows, columns) cost to go, metres weighted by the cells' prices, inf where there is no path.

    goal (x, y): the goal, or the nearest open cell where that is closed.
    """

    cost: np.ndarray
    goal: tuple[float, float]
    corner: tuple[float, float]
    cell: float

    def at(self, x, y) -> np.ndarray:
        """The cost to go from positions of any shape; inf outside the map."""
        column = np.floor((np.asarray(x) - self.corner[0]) / self.cell).astype(np.int64)
        row = np.floor((np.asarray(y) - self.corner[1]) / self.cell).astype(np.int64)
        rows, columns = self.cost.shape
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return np.where(inside, self.cost[row % rows, column % columns], np.inf)

    def path(self, x: float, y: float) -> np.ndarray:
        """(K, 2) centres of the cells on the path from (x, y) to the goal; empty where there is no path."""
        row, column = int((y - self.corner[1]) // self.cell), int((x - self.corner[0]) // self.cell)
        cells = [(row, column)] if np.isfinite(self.at(x, y)) else []
        while cells and self.cost[cells[-1]] > 0.0:
            cells.append(self._next(*cells[-1]))
        found = np.array(cells, np.float64).reshape(-1, 2)
        return (found[:, ::-1] + 0.5) * self.cell + np.array(self.corner)

    def _next(self, row: int, column: int) -> tuple[int, int]:
        """The next cell of the path: the neighbour with the least cost to go."""
        around = [(row + dr, column + dc) for dr in (-1, 0, 1) for dc in (-1, 0, 1) if dr or dc]
        inside = [cell for cell in around
                  if 0 <= cell[0] < self.cost.shape[0] and 0 <= cell[1] < self.cost.shape[1]]
        return min(inside, key=lambda cell: float(self.cost[cell]) + 1e-6 * (cell[0] != row and cell[1] != column))


def plan(occupancy: Occupancy, x: float, y: float, start: tuple[float, float] | None = None) -> Plan:
    """Plan to (x, y), or to the nearest open cell where that is closed, from every cell.

    start: where the robot stands, which may be nearer to an obstacle than a planned path.
    """
    price = prices(occupancy)
    if start:
        tight = occupancy.cells_within(*start, OUT) & ~occupancy.occupied & np.isinf(price)
        price[tight] = TIGHT
    row, column = (int(index) for index in occupancy.cells(x, y))
    low, high = extent(occupancy.known, row, column)
    price = price[low[0]:high[0], low[1]:high[1]]
    goal = nearest_open(price, row - low[0], column - low[1])
    cost = dijkstra(edges(price), directed=False, indices=goal).reshape(price.shape)
    corner = (occupancy.corner[0] + low[1] * occupancy.cell, occupancy.corner[1] + low[0] * occupancy.cell)
    if not np.isfinite(price[row - low[0], column - low[1]]):
        at_row, at_column = divmod(goal, price.shape[1])
        x, y = corner[0] + (at_column + 0.5) * occupancy.cell, corner[1] + (at_row + 0.5) * occupancy.cell
    return Plan(cost * occupancy.cell, (x, y), corner, occupancy.cell)


def extent(known: np.ndarray, row: int, column: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """The bounding box of the known cells and one more cell: (first row, column), (last row, column), with a border."""
    rows, columns = np.flatnonzero(known.any(axis=1)).tolist() or [row], np.flatnonzero(known.any(axis=0)).tolist()
    columns = columns or [column]
    low = max(0, min(rows[0], row) - BORDER), max(0, min(columns[0], column) - BORDER)
    return low, (max(rows[-1], row) + BORDER + 1, max(columns[-1], column) + BORDER + 1)


def prices(occupancy: Occupancy) -> np.ndarray:
    """(rows, columns) cost of a metre in each cell, inf where the robot's body does not fit."""
    occupied = occupancy.occupied
    price = np.where(occupancy.known, 1.0, UNKNOWN)
    if not occupied.any():
        return price
    room = ndimage.distance_transform_edt(~occupied) * occupancy.cell
    price[room < INFLATION] *= CLOSE
    price[room < BODY] = np.inf
    return price


def nearest_open(price: np.ndarray, row: int, column: int) -> int:
    """Flat index of the open cell that is nearest to (row, column)."""
    open_rows, open_columns = np.nonzero(np.isfinite(price))
    nearest = int(np.argmin((open_rows - row) ** 2 + (open_columns - column) ** 2))
    return int(open_rows[nearest] * price.shape[1] + open_columns[nearest])


def edges(price: np.ndarray) -> csr_array:
    """The grid as an undirected graph; an edge costs its length times the mean price of its ends."""
    rows, columns = price.shape
    index = np.arange(rows * columns).reshape(rows, columns)
    starts, ends, weights = [], [], []
    for down, right, length in NEIGHBOURS:
        here = (slice(0, rows - down), slice(max(0, -right), columns - max(0, right)))
        there = (slice(down, rows), slice(max(0, right), columns + min(0, right)))
        weight = 0.5 * length * (price[here] + price[there]).ravel()
        open_ = np.isfinite(weight)
        starts.append(index[here].ravel()[open_])
        ends.append(index[there].ravel()[open_])
        weights.append(weight[open_])
    ends_of = (np.concatenate(starts), np.concatenate(ends))
    return csr_array((np.concatenate(weights), ends_of), shape=(index.size, index.size))
