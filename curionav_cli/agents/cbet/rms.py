"""The running root mean square of rewards, by which they are divided so that fading ones keep their weight."""

from __future__ import annotations

import torch
from torch import Tensor, nn


class RunningRMS(nn.Module):
    """A running root mean square; momentum: how much of the running mean is kept at each update.

    The mean has no initial value: it is corrected from the first update on.
    """

    total: Tensor
    weight: Tensor

    def __init__(self, momentum: float):
        super().__init__()
        self.momentum = momentum
        for name in ("total", "weight"):
            self.register_buffer(name, torch.zeros(()))

    def reset(self) -> None:
        """Start the running mean anew."""
        self.total.zero_()
        self.weight.zero_()

    @torch.no_grad()
    def forward(self, reward: Tensor) -> Tensor:
        """Update the mean of squares with rewards (...); returns its root, a scalar above zero."""
        keep = self.momentum
        self.total.mul_(keep).add_(reward.square().mean(), alpha=1 - keep)
        self.weight.mul_(keep).add_(1 - keep)
        return (self.total / self.weight).sqrt().clamp(min=1e-8)
