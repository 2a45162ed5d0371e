"""LBS Dreamer, the agent of the paper: a world model that is surprised, and an actor that seeks it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from curionav_cli.agents.lbs_dreamer import settings
from curionav_cli.agents.setup import Setup

if TYPE_CHECKING:
    from curionav_cli.agents.agent import Agent


def make(own: settings.LBSDreamer, setup: Setup) -> Agent:
    from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer  # torch is loaded for agents that learn

    return LBSDreamer(own, setup.seed, setup.device, setup.scene.plan, setup.compile)
