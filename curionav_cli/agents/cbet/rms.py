"""Rewards over their own running root mean square, so that a reward that fades keeps its weight beside the entropy."""

from __future__ import annotations

import torch
from torch import Tensor, nn


class RunningRMS(nn.Module):
    """momentum: how much of the running mean is kept at each update. Its start does not weigh in: the mean is of what
    was seen, from the first update on."""

    total: Tensor
    weight: Tensor

    def __init__(self, momentum: float):
        super().__init__()
        self.momentum = momentum
        for name in ("total", "weight"):
            self.register_buffer(name, torch.zeros(()))

    def reset(self) -> None:
        self.total.zero_()
        self.weight.zero_()

    @torch.no_grad()
    def forward(self, reward: Tensor) -> Tensor:
        """Take the rewards (...) into the mean of squares; its root, a scalar above zero."""
        keep = self.momentum
        self.total.mul_(keep).add_(reward.square().mean(), alpha=1 - keep)
        self.weight.mul_(keep).add_(1 - keep)
        return (self.total / self.weight).sqrt().clamp(min=1e-8)
