"""Normalisation of the intrinsic reward by a running mean of its size (StreamNorm of mastering-urlb)."""

from __future__ import annotations

import torch
from torch import Tensor, nn


class StreamNorm(nn.Module):
    """Maps r to (r - centring * mean) / (magnitude + 1e-8): running means of r and of |r|.

    momentum: how much of the running means is kept at each update. centring 0 is the published form.
    The magnitude starts at one, as published; the mean has no initial value, but is corrected from the first update.
    Nothing is divided by a deviation, so that a constant reward stays constant.
    """

    total: Tensor
    weight: Tensor
    magnitude: Tensor

    def __init__(self, momentum: float, centring: float):
        super().__init__()
        self.momentum, self.centring = momentum, centring
        for name in ("total", "weight", "magnitude"):
            self.register_buffer(name, torch.zeros(()))
        self.reset()

    def reset(self) -> None:
        """Start both running means anew."""
        self.total.zero_()
        self.weight.zero_()
        self.magnitude.fill_(1)

    @torch.no_grad()
    def forward(self, reward: Tensor) -> Tensor:
        """Update the running means with rewards (...), and return these normalised."""
        keep = self.momentum
        self.total.mul_(keep).add_(reward.mean(), alpha=1 - keep)
        self.weight.mul_(keep).add_(1 - keep)
        self.magnitude.mul_(keep).add_(reward.abs().mean(), alpha=1 - keep)
        mean = self.total / self.weight.clamp(min=1e-8)
        return (reward - self.centring * mean) / (self.magnitude + 1e-8)
