"""What every reward can do. The reward of a step is the product of two factors:

    lived       what is known once an episode was lived, mostly counts; computed once, in the order of the steps
    surprise    what a network says that learns beside the policy; computed when an update uses the step, before it

A reward has its own tables, random streams and networks; a factor that it does not have is one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor, nn

from curionav_cli.agents.cbet import settings as cbet_settings
from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.reward_monitor import RewardMonitor
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.cbet.unrolls import Batch
from curionav_cli.world.scene.scene import Scene


@dataclass(frozen=True)
class RewardContext:
    """What rewards are made from. seed: of the world; numbers: where the reward's own randomness comes from."""

    hyper: cbet_settings.CBET
    world: Scene
    engine: str
    seed: int
    numbers: int


class Reward:
    """A reward of one everywhere; the others override what they need.

    counts: tables by name. dice: one random stream an environment, if there is something to draw. numbers: what
    else was drawn at the start, such as projections, is a function of this. alarm: what watches the counts.
    """

    def __init__(self, kit: RewardContext, networks: nn.ModuleDict):
        self.hyper, self.networks, self.numbers = kit.hyper, networks, kit.numbers
        self.counts: dict[str, Counts] = {}
        self.generators: list[np.random.Generator] = []
        self.alarm = RewardMonitor(math.inf)

    @staticmethod
    def build(hyper: cbet_settings.CBET) -> nn.ModuleDict:
        """The networks that learn beside the policy, each with an optimiser of its own."""
        return nn.ModuleDict()

    def episode_bonus(self, life: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        """The first factor of each of N steps, (N,) float64, and what to note in metrics.jsonl."""
        return np.ones(len(life)), {}

    def learned_bonus(self, batch: Batch) -> tuple[Tensor, Tensor]:
        """The second factor (T, B), without gradients, and a loss that trains the networks."""
        return torch.ones_like(batch.bonus), batch.bonus.new_zeros(())
