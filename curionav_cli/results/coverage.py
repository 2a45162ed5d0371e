"""Coverage from stored poses: which cells were visited, when for the first time, and how often.

Two denominators: `visitable` (cells whose centre the robot can reach) and `floor` (every cell). On a real floor without
a map there is none: cells are counted, and shares are None.
Three rules of marking a cell: `landing` (where a step ends, and the first pose; our default, and
but for the first pose the released C-BET's rule),
`swept` (every cell that the centre passes) and `footprint` (every cell whose centre the robot's disc
covers where a step ends). A cell outside the denominator never counts, so coverage is at most 1.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from curionav_cli.records import FloorPlan

Marks = tuple[np.ndarray, np.ndarray]  # (step, cell) of every mark, cells as flat indices


def landing(plan: FloorPlan, pose: np.ndarray) -> Marks:
    """Mark the cell of each pose. pose: (T+1, 3), metres and radians."""
    row, column = plan.cells(pose[:, 0], pose[:, 1])
    return np.arange(len(pose)), row * plan.visitable.shape[1] + column


def swept(plan: FloorPlan, pose: np.ndarray) -> Marks:
    """Mark every cell on the straight line from one pose to the next, and the first one's. pose: (T+1, 3).

    Between two crossings of grid lines a line stays in one cell: that of the middle between them.
    """
    step, cell = landing(plan, pose)
    start, move = pose[:-1, :2] / plan.cell, np.diff(pose[:, :2], axis=0) / plan.cell
    going = np.flatnonzero(np.abs(move).max(1) > 0)
    start, move = start[going], move[going]
    lines = np.arange(1, int(np.abs(move).max(initial=0)) + 2)[:, None, None]  # at most so many are crossed
    line = np.where(move > 0, np.floor(start) + lines, np.ceil(start) - lines)
    with np.errstate(divide="ignore", invalid="ignore"):
        time = np.nan_to_num((line - start) / move, nan=1.0, posinf=1.0, neginf=1.0).clip(0, 1)  # (lines, n, 2)
    bounds, times = np.broadcast_to([0.0, 1.0], (len(going), 2)), time.transpose(1, 0, 2)
    edges = np.sort(np.concatenate([bounds, times.reshape(len(going), 2 * len(lines))], axis=1), axis=1)
    middle = (edges[:, 1:] + edges[:, :-1]) / 2
    row, column = plan.cells(*((start[:, None] + middle[..., None] * move[:, None]) * plan.cell).transpose(2, 0, 1))
    passed = row * plan.visitable.shape[1] + column  # (n, edges)
    both = np.unique(np.concatenate([step * plan.visitable.size + cell,
                                     ((going[:, None] + 1) * plan.visitable.size + passed).ravel()]))
    return both // plan.visitable.size, both % plan.visitable.size


def footprint(plan: FloorPlan, pose: np.ndarray) -> Marks:
    """Mark every cell whose centre lies within the robot's radius of a pose. pose: (T+1, 3)."""
    reach = int(np.ceil(plan.radius / plan.cell)) + 1
    rows, columns = plan.visitable.shape
    row, column = plan.cells(pose[:, 0], pose[:, 1])
    offset = np.arange(-reach, reach + 1)
    r, c = np.broadcast_arrays(row[:, None, None] + offset[:, None], column[:, None, None] + offset)
    apart = np.hypot((c + 0.5) * plan.cell - pose[:, 0, None, None],
                     (r + 0.5) * plan.cell - pose[:, 1, None, None])
    inside = (apart <= plan.radius) & (r >= 0) & (r < rows) & (c >= 0) & (c < columns)
    step = np.broadcast_to(np.arange(len(pose))[:, None, None], inside.shape)
    return step[inside], (r * columns + c)[inside]


RULES: dict[str, Callable[[FloorPlan, np.ndarray], Marks]] = {
    "landing": landing, "swept": swept, "footprint": footprint}
DENOMINATORS = ("visitable", "floor")


class Coverage:
    """Counts cells episode by episode."""

    def __init__(self, plan: FloorPlan, rule: str = "landing", denominator: str = "visitable"):
        self.plan, self.rule, self.denominator = plan, rule, denominator
        self.counted = getattr(plan, denominator)
        self.visits = np.zeros(self.counted.shape, np.int64)
        self.steps = 0
        self.first: list[np.ndarray] = []  # the steps at which a new cell was found

    def add(self, pose: np.ndarray) -> int:
        """Count one episode, pose (T+1, 3); returns how many different cells it touched."""
        step, cell = RULES[self.rule](self.plan, pose)
        inside = self.counted.ravel()[cell]
        step, cell = step[inside], cell[inside]
        cells, at, times = np.unique(cell, return_index=True, return_counts=True)  # at: of its first, steps are sorted
        visits = self.visits.ravel()
        self.first.append(np.sort(self.steps + step[at[visits[cells] == 0]]))
        visits[cells] += times
        self.steps += len(pose) - 1
        return len(cells)

    @property
    def visited(self) -> int:
        return int((self.visits > 0).sum())

    @property
    def total(self) -> int | None:
        """The number of cells of the denominator; None on a real floor without a map."""
        return self.plan.total(self.denominator)

    @property
    def share(self) -> float | None:
        """The share of them that was visited; None where their number is not known."""
        return self.visited / self.total if self.total else None

    def curve(self) -> Curve:
        return Curve(np.concatenate([[], *self.first]).astype(np.int64), self.steps, self.total)


@dataclass(frozen=True)
class Curve:
    """When each new cell was found. found: (visited,) sorted steps; steps: of the whole run; total: cells, or None."""

    found: np.ndarray
    steps: int
    total: int | None

    @property
    def cells(self) -> int:
        """The number of cells, where it is known: comparisons refuse other runs."""
        assert self.total is not None
        return self.total

    def at(self, step: np.ndarray | int) -> np.ndarray:
        """Number of cells visited after so many steps, of the shape of `step`."""
        return np.searchsorted(self.found, step, side="right")

    def until(self, steps: int) -> Curve:
        """The curve of the first `steps` steps."""
        return Curve(self.found[:self.at(steps)], min(steps, self.steps), self.total)

    def area(self) -> float | None:
        """Mean share of the cells over the run: the area under the coverage curve, between 0 and 1; None where their
        number is not known."""
        if self.total is None:
            return None
        if not self.steps:
            return 0.0
        return float((self.steps - self.found).clip(0).sum() / (self.steps * self.total))

    def steps_to(self, share: float) -> int | None:
        """Steps until this share of the cells was visited; None if it never was, or their number is not known."""
        if self.total is None:
            return None
        needed = int(np.ceil(share * self.total))
        return int(self.found[needed - 1]) if 0 < needed <= len(self.found) else None


def cover(plan: FloorPlan, poses: Iterable[np.ndarray], rule: str = "landing",
          denominator: str = "visitable") -> Coverage:
    """Count the coverage of a whole run. poses: (T+1, 3) for each episode."""
    coverage = Coverage(plan, rule, denominator)
    for pose in poses:
        coverage.add(pose)
    return coverage
