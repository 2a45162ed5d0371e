"""The reward that agent.reward names: the class that the file of this name defines."""

from __future__ import annotations

from curionav_cli.agents.cbet import settings
from curionav_cli.agents.cbet.rewards.reward import Reward
from curionav_cli.agents.one_class import one_class


def reward_class(name: settings.Reward) -> type[Reward]:
    """Return the class in the file of this name. Another one is a file here and a line in settings.Reward."""
    return one_class(__package__, name.value, Reward)
