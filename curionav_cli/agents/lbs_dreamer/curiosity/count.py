"""The oracle: counts of true cells, which no robot can know.

    r = 1 / sqrt(N(cell))        (Strehl and Littman, 2008, MBIE-EB; Bellemare et al., 2016, section 4)

N is how often an action (held for agent.action_repeat steps) ended in a cell, in all that was lived. It tells what
the world model and the actor-critic can make of a perfect signal; a head carries it into imagination as in lbs.py.
"""

from __future__ import annotations

import numpy as np
from torch import Tensor

from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Head, Notes
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences
from curionav_cli.records import FloorPlan
from curionav_cli.storage.replay import Replay


class Count(Head):
    """Oracle: the bonus of a state's true cell."""

    def notes(self, plan: FloorPlan) -> Notes:
        return Visits(plan)

    def target(self, seen: Observed, data: Sequences, noise: Tensor) -> Tensor:
        assert data.noted is not None, "the agent must hand over the counts"
        return data.noted.clamp(min=1).rsqrt()


class Visits:
    """How often each cell of a floor plan was landed on."""

    def __init__(self, plan: FloorPlan):
        self.plan = plan
        self.table = np.zeros(plan.visitable.shape, np.int64)
        self.episodes = 0  # that are in the table

    def take_in(self, replay: Replay) -> None:
        """Count the episodes that are new."""
        for index in range(self.episodes, len(replay)):
            np.add.at(self.table, self.plan.cells(*replay.episode(index).pose[:, :2].T), 1)
        self.episodes = len(replay)

    def of(self, which: np.ndarray, start: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """Of windows that were drawn, (B, L) float32. which, start: (B,); pose: (B, L, 3) metres and radians."""
        return self.table[self.plan.cells(pose[..., 0], pose[..., 1])].astype(np.float32)
