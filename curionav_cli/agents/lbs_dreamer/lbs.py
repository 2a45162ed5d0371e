"""Latent Bayesian Surprise, equation (2) of the paper.

    r_expl = I(s_{t+1}; x_{t+1} | s_t, a_t) ~ KL[ q(s_{t+1} | s_t, a_t, x_{t+1}) || p(s_{t+1} | s_t, a_t) ]

In imagination there is no x_{t+1}, so a head learns the KL that was measured on the replay from the
state that was reached, and imagined rewards are its mean (as mastering-urlb does it). What a
curiosity must be able to do: `loss` on what was observed, `reward` of what was imagined.
"""

from __future__ import annotations

import torch
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer import latent
from curionav_cli.agents.lbs_dreamer.networks import MLP
from curionav_cli.agents.lbs_dreamer.rssm import Observed


def settled(steps: int, is_start: Tensor, burn_in: int) -> Tensor:
    """(T, B) bool: false on the first `burn_in` steps of windows that start in mid-episode.

    There the model starts from a zero state, and the KL tells of that and not of the world.
    is_start (B,) bool.
    """
    step = torch.arange(steps, device=is_start.device)
    return (step[:, None] >= burn_in) | is_start[None]


class LBS(nn.Module):
    """The head: state -> expected surprise in nats."""

    def __init__(self, features: int, units: int, layers: int, burn_in: int):
        super().__init__()
        self.head = MLP(features, units, layers, 1)
        self.burn_in = burn_in

    def loss(self, seen: Observed, is_start: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """Regression on the measured KL, -log N(KL; head, 1) without its constant, where settled.

        No gradient reaches the world model. is_start (B,) bool.
        """
        target = latent.kl(seen.posterior, seen.prior).detach()  # (T, B)
        predicted = self.head(seen.states.features.detach()).squeeze(-1).float()  # (T, B)
        mask = settled(len(target), is_start, self.burn_in).float()
        error = (mask * (predicted - target).square()).sum() / mask.sum().clamp(min=1)
        metrics = {
            "kl": target.mean(), "lbs_target": masked_mean(target, mask), "lbs_loss": error / 2,
            "lbs_correlation": correlation(predicted.detach(), target, mask),
        }
        return error / 2, metrics

    def reward(self, features: Tensor) -> Tensor:
        """Expected surprise on arrival in imagined states (..., F) -> (...), never below zero."""
        return self.head(features).squeeze(-1).float().clamp(min=0)


def masked_mean(x: Tensor, mask: Tensor) -> Tensor:
    """Mean of x where mask is one."""
    return (mask * x).sum() / mask.sum().clamp(min=1)


def correlation(x: Tensor, y: Tensor, mask: Tensor) -> Tensor:
    """Pearson's, where mask is one; zero where one of them is constant."""
    x, y = x - masked_mean(x, mask), y - masked_mean(y, mask)
    spread = masked_mean(x * x, mask) * masked_mean(y * y, mask)
    return masked_mean(x * y, mask) / (spread.sqrt() + 1e-8)
