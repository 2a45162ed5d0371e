"""Random Network Distillation on latents (Burda et al., 2018, section 2.2: r = ||f'(x) - f(x)||^2).

A network learns what another, frozen at its random weights, makes of a state; where it fails, it has
seen little. The inputs are the world model's states, which change while it learns.
"""

from __future__ import annotations

from torch import Tensor

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity, masked_mean, settled
from curionav_cli.agents.lbs_dreamer.kernels.mlp import MLP
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class RND(Curiosity):
    """Squared distance, summed over `units` outputs."""

    def __init__(self, rssm: RSSM, units: int, layers: int, burn_in: int):
        super().__init__(rssm, units, layers, burn_in)
        self.frozen = MLP(rssm.features, units, layers, units).requires_grad_(False)
        self.learner = MLP(rssm.features, units, layers, units)

    def error(self, features: Tensor) -> Tensor:
        """(..., F) -> (...)"""
        return (self.learner(features) - self.frozen(features)).float().square().sum(-1)

    def loss(self, seen: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        error = self.error(seen.states.features)  # (T, B)
        mean = masked_mean(error, settled(len(error), data.is_start, self.burn_in).float())
        return mean, {"curiosity_target": mean}

    def reward(self, imagined: Imagined) -> Tensor:
        return self.error(imagined.features)
