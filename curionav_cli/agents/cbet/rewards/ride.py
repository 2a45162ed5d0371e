"""RIDE (Raileanu and Rocktaschel, 2020): the distance of a step in ICM's features, over sqrt(N(s')) of the episode."""

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
    """ICM's features and episodic counts, which are cleared after each episode, the respawn counted."""

    def __init__(self, context: RewardContext, networks: nn.ModuleDict):
        super().__init__(context, networks)
        self.count = Count(context, nn.ModuleDict())
        self.counts = self.count.counts
        self.monitor = self.count.monitor = RewardMonitor(math.inf)  # the learned factor has no upper bound

    def episode_bonus(self, transitions: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        """1 / sqrt(N(s')) of each step (N,), and metrics of the counts."""
        bonus, metrics = self.count.episode_bonus(transitions)
        self.counts["states"].clear(transitions.environment)
        return bonus, metrics

    def novelty(self, before: Tensor, after: Tensor, error: Tensor) -> Tensor:
        """The distance (T, B) of the features (T, B, F) of a step's two images."""
        return torch.linalg.vector_norm(after - before, dim=-1)
