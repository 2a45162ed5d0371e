"""A privileged control: r = 1 / sqrt(N), counts of the true coverage cell, one table for all."""

from __future__ import annotations

import numpy as np
from torch import nn

from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.rewards.reward import Reward, RewardContext
from curionav_cli.agents.cbet.transitions import Transitions


class CountOracle(Reward):
    """Counts of cells; the cell of a step is the one where it ended, also in the last step of an episode."""

    def __init__(self, context: RewardContext, networks: nn.ModuleDict):
        super().__init__(context, networks)
        self.plan = context.scene.plan
        self.counts = {"cells": Counts(1)}

    def episode_bonus(self, transitions: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        """1 / sqrt(N(cell)) of each step (N,), and the mean count."""
        cells = np.stack(self.plan.cells(*transitions.episode.pose[1:, :2].T), axis=1).astype("<i4")
        count = np.array([self.counts["cells"].add(0, cell.tobytes()) for cell in cells])
        return count**-0.5, {"count_of_cell": count.mean()}
