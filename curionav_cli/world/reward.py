"""Extrinsic rewards for other trainers. The agents of this package use none of them."""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.records import FloorPlan

REWARDS = ("none", "coverage", "count")


class Reward:
    """The reward of a step, by the visits of this episode to the cell in which it ends; the start is a visit.

    none: 0.0. coverage: 1.0 for the first visit to a visitable cell. count: 1/sqrt(N) for a cell's N-th visit. The last
    two are privileged: they use the true pose and the cells, which no robot measures. Raises ValueError for another
    name.
    """

    def __init__(self, name: str = "none"):
        if name not in REWARDS:
            raise ValueError(f"reward must be one of {', '.join(REWARDS)}, not {name!r}.")
        self.name = name

    def reset(self, plan: FloorPlan, x: float, y: float) -> None:
        """Begin an episode at (x, y), metres."""
        self.plan, self.visits = plan, np.zeros(plan.visitable.shape, np.int64)
        self.step(x, y)

    def step(self, x: float, y: float) -> float:
        """The reward of a step that ends at (x, y), metres."""
        if self.name == "none":
            return 0.0
        cell = self.plan.cells(np.asarray(x), np.asarray(y))
        self.visits[cell] += 1
        visits = int(self.visits[cell])
        if self.name == "count":
            return 1.0 / math.sqrt(visits)
        return float(visits == 1 and self.plan.visitable[cell])
