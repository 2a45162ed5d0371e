"""A control that is told where it is: 1 / sqrt(N), visits of the true coverage cell, one table for all."""

from __future__ import annotations

import numpy as np
from torch import nn

from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.rewards.reward import Reward, RewardContext
from curionav_cli.agents.cbet.transitions import Transitions


class CountOracle(Reward):
    """Privileged. The cell is that of the landing, also in the last step of an episode."""

    def __init__(self, kit: RewardContext, networks: nn.ModuleDict):
        super().__init__(kit, networks)
        self.plan = kit.world.plan
        self.counts = {"cells": Counts(1)}

    def episode_bonus(self, life: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        cells = np.stack(self.plan.cells(*life.episode.pose[1:, :2].T), axis=1).astype("<i4")
        met = np.array([self.counts["cells"].add(0, cell.tobytes()) for cell in cells])
        return met**-0.5, {"count_of_cell": met.mean()}
