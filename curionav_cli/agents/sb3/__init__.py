"""Algorithms of Stable-Baselines3 and sb3-contrib in our loop, with intrinsic rewards of ours."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING

from curionav_cli.agents.sb3 import settings
from curionav_cli.agents.setup import Setup

if TYPE_CHECKING:
    from curionav_cli.agents.agent import Agent

CONTRIB = (settings.Algorithm.RecurrentPPO, settings.Algorithm.TRPO, settings.Algorithm.QRDQN)
OFF_POLICY = (settings.Algorithm.DQN, settings.Algorithm.QRDQN)


def missing(own: settings.SB3) -> str:
    """What these settings need and is not installed; empty where nothing is missing."""
    package = "sb3_contrib" if own.algorithm in CONTRIB else "stable_baselines3"
    return "" if find_spec(package) else (f"agent=sb3 agent.algorithm={own.algorithm.value} needs {package}, which is "
                                          "not installed: .venv/bin/pip install -c constraints.txt -e '.[sb3]'")


def make(own: settings.SB3, setup: Setup) -> Agent:
    """Make the agent from its own settings and the run's."""
    if own.algorithm in OFF_POLICY:
        from curionav_cli.agents.sb3.off_policy import OffPolicy  # torch and SB3 are loaded for agents that learn

        return OffPolicy(own, setup.seed, setup.device)
    from curionav_cli.agents.sb3.on_policy import OnPolicy

    return OnPolicy(own, setup.seed, setup.device)
