"""A control without memory: half a point for every step that moved the robot, which C-BET's reward nearly is."""

from __future__ import annotations

import numpy as np

from curionav_cli.agents.cbet.rewards.reward import Reward
from curionav_cli.agents.cbet.transitions import MOVED, Transitions


class Motion(Reward):
    """0.5 where the position changed."""

    def episode_bonus(self, life: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        return np.where(life.kind == MOVED, 0.5, 0.0), {}
