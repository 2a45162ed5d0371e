"""RIDE (Raileanu and Rocktaschel, 2020): how far a step moves in ICM's features, over sqrt(N(s')) of the episode."""

from __future__ import annotations

import math

import numpy as np
import torch
from torch import Tensor, nn

from curionav_cli.agents.cbet.reward_monitor import RewardMonitor
from curionav_cli.agents.cbet.rewards.count import Count
from curionav_cli.agents.cbet.rewards.icm import ICM
from curionav_cli.agents.cbet.rewards.reward import RewardContext
from curionav_cli.agents.cbet.transitions import Transitions


class RIDE(ICM):
    """Counts are forgotten with each episode, after the respawn was counted."""

    def __init__(self, kit: RewardContext, networks: nn.ModuleDict):
        super().__init__(kit, networks)
        self.count = Count(kit, nn.ModuleDict())
        self.counts = self.count.counts
        self.alarm = self.count.alarm = RewardMonitor(math.inf)  # the other factor has no ceiling

    def episode_bonus(self, life: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        bonus, watch = self.count.episode_bonus(life)
        self.counts["states"].clear(life.environment)
        return bonus, watch

    def novelty(self, before: Tensor, after: Tensor, error: Tensor) -> Tensor:
        return torch.linalg.vector_norm(after - before, dim=-1)
