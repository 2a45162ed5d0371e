"""Count: 1 / sqrt(N(s')), keys as C-BET's, a table an environment that is never forgotten."""

from __future__ import annotations

import numpy as np
from torch import nn

from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.reward_monitor import RewardMonitor
from curionav_cli.agents.cbet.rewards.reward import Reward, RewardContext
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.image_hash import StateKeys


class Count(Reward):
    """counts["states"] holds the pictures."""

    def __init__(self, kit: RewardContext, networks: nn.ModuleDict):
        super().__init__(kit, networks)
        rng = np.random.default_rng(kit.numbers)
        self.state_keys = StateKeys(kit.hyper.key.value, kit.hyper.key_bits, rng)
        self.counts = {"states": Counts(kit.hyper.environments)}
        self.alarm = RewardMonitor(1.0)

    def episode_bonus(self, life: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        keys = self.state_keys(life.episode.image[life.reached])
        met = np.array([self.counts["states"].add(life.environment, key) for key in keys])
        bonus, poses, unique = met**-0.5, life.poses(), len(set(keys[:-1]))
        self.alarm.look(poses, unique, bonus)
        return bonus, {"unique_states": len(set(keys)) / len(keys), "unique_of_new_poses": unique / max(1, poses),
                       "count_of_state": met.mean()}
