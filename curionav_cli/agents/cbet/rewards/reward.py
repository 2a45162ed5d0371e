"""The contract of an intrinsic reward. The reward of a step is the product of two factors:

    episode_bonus    mostly of counts; computed once, after the episode, in the order of its steps
    learned_bonus    of a network that learns beside the policy; computed by each update that uses the step, before it

A reward has its own tables, generators and networks; a factor that it does not define is one.

Letters: N steps of an episode, E environments, T steps of an unroll, B unrolls.
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
from curionav_cli.world.real_floor import RealFloor
from curionav_cli.world.scene.scene import Scene


@dataclass(frozen=True)
class RewardContext:
    """What rewards are made from.

    seed: the run's, for changes of the scene; reward_seed: of the reward's own random numbers.
    """

    hyper: cbet_settings.CBET
    scene: Scene | RealFloor
    engine: str
    seed: int
    reward_seed: int


class Reward:
    """A reward of one everywhere; the others override what they need.

    counts: tables by name. generators: one for each environment, if there is something to draw. seed: of all else that
    is random, such as projections. monitor: warns of degenerate counts.
    """

    def __init__(self, context: RewardContext, networks: nn.ModuleDict):
        self.hyper, self.networks, self.seed = context.hyper, networks, context.reward_seed
        self.counts: dict[str, Counts] = {}
        self.generators: list[np.random.Generator] = []
        self.monitor = RewardMonitor(math.inf)

    @staticmethod
    def build(hyper: cbet_settings.CBET) -> nn.ModuleDict:
        """Make the networks that learn beside the policy; each gets an optimiser of its own."""
        return nn.ModuleDict()

    def episode_bonus(self, transitions: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        """The first factor (N,) float64, and metrics for metrics.jsonl."""
        return np.ones(len(transitions)), {}

    def learned_bonus(self, batch: Batch) -> tuple[Tensor, Tensor]:
        """The second factor (T, B), without gradients, and the scalar loss of the networks."""
        return torch.ones_like(batch.bonus), batch.bonus.new_zeros(())
