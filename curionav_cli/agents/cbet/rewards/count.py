"""Count: r = 1 / sqrt(N(s')), with C-BET's keys, and a table for each environment that is never cleared."""

from __future__ import annotations

import numpy as np
from torch import nn

from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.reward_monitor import RewardMonitor
from curionav_cli.agents.cbet.rewards.reward import Reward, RewardContext
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.image_hash import StateKeys


class Count(Reward):
    """Counts of images; counts["states"] is their table."""

    def __init__(self, context: RewardContext, networks: nn.ModuleDict):
        super().__init__(context, networks)
        rng = np.random.default_rng(context.reward_seed)
        self.state_keys = StateKeys(context.hyper.key.value, context.hyper.key_bits, rng)
        self.counts = {"states": Counts(context.hyper.environments)}
        self.monitor = RewardMonitor(1.0)

    def episode_bonus(self, transitions: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        """1 / sqrt(N(s')) of each step (N,), and metrics of the counts."""
        keys = self.state_keys(transitions.episode.image[transitions.reached])
        count = np.array([self.counts["states"].add(transitions.environment, key) for key in keys])
        bonus, poses, unique = count**-0.5, transitions.poses(), len(set(keys[:-1]))
        self.monitor.update(poses, unique, bonus)
        return bonus, {"unique_states": len(set(keys)) / len(keys), "unique_of_new_poses": unique / max(1, poses),
                       "count_of_state": count.mean()}
