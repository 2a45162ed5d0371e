"""The settings of the curious mapping explorer; the values stand in conf/agent/curious_mapper.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from curionav_cli.agents.lbs_dreamer.settings import BehaviourKind, Curiosity, LBSDreamer
from curionav_cli.bounds import bounded
from curionav_cli.constants import OptionSet


class Surprise(Enum):
    """What is remembered of a view: its measured surprise; or, as controls, that of another view; visits alone."""

    measured = "measured"
    shuffled = "shuffled"
    visits = "visits"


@dataclass(frozen=True)
class CuriousMapper(LBSDreamer):
    """Drives on a map of its own to where its world model is expected to be surprised; no privileges.

    The world model and its settings are those of lbs_dreamer. There is no actor and no critic: their settings, which
    the presets of a scale hold, are neither offered nor taken.
    """

    UNREAD: ClassVar[frozenset[str]] = frozenset((
        "curiosity", "slow_critic_interval", "horizon", "gamma", "return_lambda", "actor_lr", "critic_lr", "entropy",
        "options", "action_repeat", "behaviour", "plan_depth", "plan_samples", "plan_temperature",
        "behaviour_interval", "imagination_starts", "reward_momentum", "reward_centring"))
    surprise: Surprise
    reach: float  # metres of a view that are entered into the map of obstacles
    sight: float  # metres of a view to which its surprise is ascribed
    stay: float  # actions spent at a goal, beside the way there: the higher, the less a way matters
    optimism: float  # quantile of first sights that a place not yet seen is expected to have

    def __post_init__(self) -> None:
        super().__post_init__()
        bounded("agent", self, {"reach": (0.5, 10.0), "sight": (0.1, 10.0), "stay": (0, 10**6), "optimism": (0, 1)})
        if self.action_repeat != 1:
            raise ValueError(f"agent.action_repeat: {self.action_repeat} is not 1; a way is planned action by action")
        if self.options is not OptionSet.none or self.behaviour is not BehaviourKind.actor:
            raise ValueError("agent.options and agent.behaviour: a way is planned action by action, on the map; "
                             "leave them as they are")
        if self.curiosity is not Curiosity.none:
            raise ValueError(f"agent.curiosity: {self.curiosity.value} is not none; no reward is imagined, and "
                             "agent.surprise is what can be chosen")
