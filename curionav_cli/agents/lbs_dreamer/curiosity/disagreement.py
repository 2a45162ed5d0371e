"""Latent disagreement of an ensemble (Plan2Explore, Sekar et al., 2020, equations (3) to (5)).

K small networks predict the next latent state from this one and the action. Where data is plentiful they agree; the
intrinsic reward is the variance of their predictions, averaged over the dimensions. As in DreamerV2's Plan2Explore they
predict the stochastic state, not the image's embedding.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity, masked_mean, settled
from curionav_cli.agents.lbs_dreamer.kernels.mlp import MLP
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, Observed, one_hot_action
from curionav_cli.agents.lbs_dreamer.world_model import Sequences

MEMBERS = 5


class Disagreement(Curiosity):
    """An ensemble of K = MEMBERS networks with one hidden layer each."""

    def __init__(self, rssm: RSSM, units: int, layers: int, burn_in: int):
        super().__init__(rssm, units, layers, burn_in)
        self.actions = rssm.actions
        self.members = nn.ModuleList(
            MLP(rssm.features + rssm.actions, units, 1, rssm.stoch) for _ in range(MEMBERS))

    def predictions(self, features: Tensor, action: Tensor) -> Tensor:
        """Predict the next z (K, T, B, S * C) from features (T, B, F) and the actions taken there (T, B)."""
        x = torch.cat([features, one_hot_action(action, self.actions).to(features.dtype)], -1)
        return torch.stack([member(x) for member in self.members]).float()

    def loss(self, observed: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """Sum of squared errors of the next state, mean over members and settled steps."""
        predicted = self.predictions(observed.states.features[:-1], data.action[1:])
        error = (predicted - observed.states.stoch[1:]).square().sum(-1).mean(0)  # (T - 1, B)
        mask = settled(len(data.action), data.is_start, self.burn_in)[:-1].float()
        mean = masked_mean(error, mask)
        return mean, {"curiosity_target": masked_mean(predicted.detach().var(0).mean(-1), mask)}

    def intrinsic_reward(self, imagined: Imagined) -> Tensor:
        """The variance (H + 1, N); zero for s_0, which no imagined action led to."""
        spread = self.predictions(imagined.features[:-1], imagined.action).var(0).mean(-1)  # (H, N)
        return torch.cat([torch.zeros_like(spread[:1]), spread])
