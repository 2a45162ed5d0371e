"""The settings of C-BET; the values stand in conf/agent and conf/scale/cbet."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from curionav_cli.bounds import bounded, within


class Reward(Enum):
    """The intrinsic reward; agents/cbet/rewards has a file for each."""

    cbet = "cbet"
    count = "count"
    rnd = "rnd"
    icm = "icm"
    ride = "ride"
    motion = "motion"
    count_oracle = "count_oracle"


class View(Enum):
    """The view whose changes are counted: a panorama that only a simulator has, or the robot's own image."""

    pano = "pano"
    ego = "ego"


class Difference(Enum):
    """The difference of two images: modulo 256, as released, or with its sign."""

    wrapped = "wrapped"
    signed = "signed"


class Key(Enum):
    """The numbers of an image that its key is made from: all, or sums of grey on a grid of 16 x 16 or 8 x 8."""

    raw = "raw"
    grey_16 = "grey_16"
    grey_8 = "grey_8"


class Tables(Enum):
    """The tables of counts: one for each environment, or one for all."""

    own = "own"
    shared = "shared"


class Reset(Enum):
    """When a table of counts is cleared: at random, after each episode, never."""

    random = "random"
    episode = "episode"
    never = "never"


@dataclass(frozen=True)
class CBET:
    """C-BET as released, with its siblings and controls (agent.reward)."""

    name: str
    reward: Reward
    # Counts
    view: View
    difference: Difference
    key: Key
    key_bits: int
    tables: Tables
    reset: Reset
    reset_prob: float
    count_teleport: bool
    # Reward
    coefficient: dict[str, float]  # the factor of each reward; of one that is not named here, 1
    reward_clip: float
    normalise: bool
    rms_momentum: float
    rms_size: float
    # Schedule
    environments: int
    unroll: int
    batch_size: int
    # V-trace
    gamma: float
    value_cost: float
    entropy: float
    lr: float
    rmsprop_decay: float
    rmsprop_epsilon: float
    clip: float
    # Networks
    conv_channels: list[int]
    dense_units: list[int]
    lstm_units: int
    lstm_layers: int
    rnd_loss: float
    forward_loss: float
    inverse_loss: float

    def __post_init__(self) -> None:
        bounded("agent", self, {
            "reset_prob gamma rmsprop_decay lr rmsprop_epsilon": (0, 1), "rms_momentum": (0, 0.9999),
            "value_cost entropy rnd_loss forward_loss inverse_loss": (0, 10**6),
            "clip reward_clip rms_size": (1e-8, 1e9), "lstm_layers": (1, 100), "environments": (1, 1000),
            "key_bits batch_size lstm_units": (1, 10**4), "unroll": (1, 10**6)})
        for name, factor in self.coefficient.items():
            if name not in Reward.__members__:
                raise ValueError(f"agent.coefficient: no reward has the name {name}: {', '.join(Reward.__members__)}")
            within(f"agent.coefficient.{name}", factor, least=-10**6, most=10**6)
        for name in ("conv_channels", "dense_units"):
            for number in getattr(self, name) or [0]:
                within(f"agent.{name}", number, least=1, most=10**4)
        if self.key is not Key.raw and self.difference is Difference.wrapped:
            raise ValueError(f"agent.difference: wrapped has no meaning for sums of grey (agent.key={self.key.value}); "
                             "set agent.difference=signed")


@dataclass(frozen=True)
class CBETLifelong(CBET):
    """C-BET strengthened by us: one table for all that is never cleared, rewards divided by their running size."""
