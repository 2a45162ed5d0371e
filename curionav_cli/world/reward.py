"""What a step may earn in other people's trainers. Our own agents read no reward."""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.records import FloorPlan

REWARDS = ("none", "coverage", "count")


class Reward:
    """What a step earns by the cell that it ends in, from the visits of this episode; the start counts as one.

    none: 0.0. coverage: 1.0 for a visitable cell that is visited first in this episode. count: 1/sqrt(N) at a cell's
    N-th visit. Both are privileged: they are told the true pose and the cells, which no robot sees.
    Raises ValueError for another name.
    """

    def __init__(self, name: str = "none"):
        if name not in REWARDS:
            raise ValueError(f"reward must be one of {', '.join(REWARDS)}, not {name!r}.")
        self.name = name

    def begin(self, plan: FloorPlan, x: float, y: float) -> None:
        """An episode begins at (x, y), in metres."""
        self.plan, self.visits = plan, np.zeros(plan.visitable.shape, np.int64)
        self.land(x, y)

    def land(self, x: float, y: float) -> float:
        """What the step earns that ends at (x, y), in metres."""
        if self.name == "none":
            return 0.0
        cell = self.plan.cells(np.asarray(x), np.asarray(y))
        self.visits[cell] += 1
        visits = int(self.visits[cell])
        if self.name == "count":
            return 1.0 / math.sqrt(visits)
        return float(visits == 1 and self.plan.visitable[cell])
