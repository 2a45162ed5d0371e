"""An oracle: counts of visits to true cells, which a robot cannot measure.

    r = 1 / sqrt(N(cell))        (Strehl and Littman, 2008, MBIE-EB; Bellemare et al., 2016, section 4)

N is how often an action (held for agent.action_repeat steps) ended in a cell, over all episodes. It shows what world
model and actor-critic make of a perfect intrinsic reward; a head carries it into imagination as in lbs.py.
"""

from __future__ import annotations

import numpy as np
from torch import Tensor

from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Head, VisitCounts
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences
from curionav_cli.records import FloorPlan
from curionav_cli.storage.replay import Replay


class Count(Head):
    """Bonus of a state's true cell."""

    def visit_counts(self, plan: FloorPlan) -> VisitCounts:
        """Counts by the cells of the floor plan."""
        return CellCounts(plan)

    def target(self, observed: Observed, data: Sequences, noise: Tensor) -> Tensor:
        """1 / sqrt(N) of each step: (T, B)."""
        assert data.counts is not None, "the agent must pass the counts"
        return data.counts.clamp(min=1).rsqrt()


class CellCounts:
    """Counts how often an action ended in each cell of a floor plan."""

    def __init__(self, plan: FloorPlan):
        self.plan = plan
        self.table = np.zeros(plan.visitable.shape, np.int64)
        self.episodes = 0  # that are in the table

    def update(self, replay: Replay) -> None:
        """Count the episodes that are new in the replay."""
        for index in range(self.episodes, len(replay)):
            np.add.at(self.table, self.plan.cells(*replay.episode(index).pose[:, :2].T), 1)
        self.episodes = len(replay)

    def of_windows(self, which: np.ndarray, start: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """Counts (B, L) float32 of the cells of pose (B, L, 3), in metres."""
        return self.table[self.plan.cells(pose[..., 0], pose[..., 1])].astype(np.float32)
