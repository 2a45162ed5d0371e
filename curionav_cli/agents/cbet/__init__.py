"""C-BET (Parisi et al., NeurIPS 2021), its siblings and controls: one learner, and one file for each reward."""

from __future__ import annotations

from typing import TYPE_CHECKING

from curionav_cli.agents.cbet import settings
from curionav_cli.agents.setup import Setup

if TYPE_CHECKING:
    from curionav_cli.agents.agent import Agent


def privileged(own: settings.CBET) -> str:
    """What of these settings needs a scene; empty where nothing does."""
    pano = own.view is settings.View.pano and own.reward is settings.Reward.cbet
    return "agent.view=pano is a panorama that only a simulator can take. Set agent.view=ego" if pano else ""


def make(own: settings.CBET, setup: Setup) -> Agent:
    """Make the agent from its own settings and the run's."""
    from curionav_cli.agents.cbet.agent import CBET  # torch is loaded for agents that learn

    return CBET(own, setup.seed, setup.device, setup.scene, setup.engine)
