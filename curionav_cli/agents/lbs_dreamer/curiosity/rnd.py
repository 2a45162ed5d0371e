"""Random Network Distillation on latents (Burda et al., 2018, section 2.2: r = ||f'(x) - f(x)||^2).

A network learns to predict the outputs of another, frozen at its random weights, for a state; its error, the intrinsic
reward, is large where data is scarce. The inputs are the world model's states, which change while that learns.
"""

from __future__ import annotations

from torch import Tensor

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity, masked_mean, settled
from curionav_cli.agents.lbs_dreamer.kernels.mlp import MLP
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class RND(Curiosity):
    """Squared error of the prediction, summed over `units` outputs."""

    def __init__(self, rssm: RSSM, units: int, layers: int, burn_in: int):
        super().__init__(rssm, units, layers, burn_in)
        self.frozen = MLP(rssm.features, units, layers, units).requires_grad_(False)
        self.learner = MLP(rssm.features, units, layers, units)

    def error(self, features: Tensor) -> Tensor:
        """Squared error (...) for features (..., F)."""
        return (self.learner(features) - self.frozen(features)).float().square().sum(-1)

    def loss(self, observed: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """Mean error over the settled steps: scalar."""
        error = self.error(observed.states.features)  # (T, B)
        mean = masked_mean(error, settled(len(error), data.is_start, self.burn_in).float())
        return mean, {"curiosity_target": mean}

    def intrinsic_reward(self, imagined: Imagined) -> Tensor:
        """The squared error (H + 1, N)."""
        return self.error(imagined.features)
