"""Rewards divided by a running mean of their size (StreamNorm of mastering-urlb)."""

from __future__ import annotations

import torch
from torch import Tensor, nn


class StreamNorm(nn.Module):
    """(r - centring * mean) / (magnitude + 1e-8), both running means, the magnitude of |r|.

    momentum: how much of the running means is kept at each update. centring 0 is the published form.
    A signal without spread stays without: nothing is divided by a deviation.
    """

    mean: Tensor
    magnitude: Tensor

    def __init__(self, momentum: float, centring: float):
        super().__init__()
        self.momentum, self.centring = momentum, centring
        self.register_buffer("mean", torch.zeros(()))
        self.register_buffer("magnitude", torch.ones(()))

    @torch.no_grad()
    def forward(self, reward: Tensor) -> Tensor:
        """Take the rewards (...) into the running means, then scale them."""
        self.mean.lerp_(reward.mean(), 1 - self.momentum)
        self.magnitude.lerp_(reward.abs().mean(), 1 - self.momentum)
        return (reward - self.centring * self.mean) / (self.magnitude + 1e-8)
