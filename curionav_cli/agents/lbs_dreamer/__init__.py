"""LBS Dreamer, the agent of the paper: a world model, and an actor whose intrinsic reward is the model's surprise."""

from __future__ import annotations

from typing import TYPE_CHECKING

from curionav_cli.agents.lbs_dreamer import settings
from curionav_cli.agents.setup import Setup

if TYPE_CHECKING:
    from curionav_cli.agents.agent import Agent


def make(own: settings.LBSDreamer, setup: Setup) -> Agent:
    """Make the agent from its own settings and the run's."""
    from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer  # torch is loaded for agents that learn

    return LBSDreamer(own, setup.seed, setup.device, setup.scene.plan, setup.compile)
