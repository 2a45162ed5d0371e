"""The settings of agent=sb3; the values stand in conf/agent/sb3.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from curionav_cli.agents.cbet.settings import Key
from curionav_cli.bounds import bounded, within


class Algorithm(Enum):
    """An algorithm of Stable-Baselines3 or sb3-contrib for discrete actions."""

    PPO = "PPO"
    A2C = "A2C"
    RecurrentPPO = "RecurrentPPO"
    TRPO = "TRPO"
    DQN = "DQN"
    QRDQN = "QRDQN"


class Reward(Enum):
    """The intrinsic reward: counts of images, or the error of predicting a random network's features."""

    count = "count"
    rnd = "rnd"


@dataclass(frozen=True)
class SB3:
    """An algorithm of Stable-Baselines3 with an intrinsic reward of ours."""

    name: str
    algorithm: Algorithm
    reward: Reward
    parameters: dict[str, Any]  # of the algorithm's class, by its own names
    unroll: int  # steps of a rollout, of the algorithms that learn on-policy
    schedule_steps: int
    key: Key
    key_bits: int
    conv_channels: list[int]
    rnd_lr: float
    rnd_batch: int
    rms_momentum: float

    def __post_init__(self) -> None:
        bounded("agent", self, {"unroll schedule_steps": (2, 10**9), "key_bits rnd_batch": (1, 10**4),
                                "rnd_lr": (0, 1), "rms_momentum": (0, 0.9999)})
        for number in self.conv_channels or [0]:
            within("agent.conv_channels", number, least=1, most=10**4)
