"""A control without memory: r = 0.5 for every step that moved the robot, which C-BET's reward is close to."""

from __future__ import annotations

import numpy as np

from curionav_cli.agents.cbet.rewards.reward import Reward
from curionav_cli.agents.cbet.transitions import MOVED, Transitions


class Motion(Reward):
    """A reward of 0.5 where the position changed."""

    def episode_bonus(self, transitions: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        """0.5 or 0 for each step (N,)."""
        return np.where(transitions.kind == MOVED, 0.5, 0.0), {}
