"""The contract: what a curiosity must be able to do, and the regression head that most of them are.

Letters: T steps, B sequences, F features, H horizon, N imagined lives.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Protocol

import numpy as np
import torch
from torch import Tensor, nn

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.kernels.mlp import MLP
from curionav_cli.agents.lbs_dreamer.rssm import RSSM, Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences
from curionav_cli.records import FloorPlan
from curionav_cli.storage.replay import Replay


class Notes(Protocol):
    """A number for every step of the replay, which changes as the replay grows."""

    def take_in(self, replay: Replay) -> None:
        """Count the episodes that are new."""

    def of(self, which: np.ndarray, start: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """Of windows that were drawn, (B, L) float32. which, start: (B,); pose: (B, L, 3) metres and radians."""


class Curiosity(nn.Module, ABC):
    """Learns on what was observed, judges what is imagined. No gradient of it reaches the world model.

    units, layers: size of its networks. burn_in: see `settled`.
    """

    def __init__(self, rssm: RSSM, units: int, layers: int, burn_in: int):
        super().__init__()
        self.burn_in = burn_in

    def notes(self, plan: FloorPlan) -> Notes | None:
        """What is to be noted of every step that the replay holds, as `Sequences.noted`; None for nothing."""
        return None

    @abstractmethod
    def loss(self, seen: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """Scalar loss and metrics; seen is detached, noise (T, B) uniform in [0, 1)."""

    @abstractmethod
    def reward(self, imagined: Imagined) -> Tensor:
        """(H + 1, N): reward i is that of arriving in imagined state i. Nothing below zero."""


class Head(Curiosity):
    """A network of the state that is fitted to a number measured on the replay."""

    def __init__(self, rssm: RSSM, units: int, layers: int, burn_in: int):
        super().__init__(rssm, units, layers, burn_in)
        self.head = MLP(rssm.features, units, layers, 1, rssm.stoch)

    @abstractmethod
    def target(self, seen: Observed, data: Sequences, noise: Tensor) -> Tensor:
        """(T, B): what is worth being curious about, as it was measured."""

    def loss(self, seen: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """-log N(target; head, 1) without its constant, mean over the settled steps."""
        target = self.target(seen, data, noise)
        predicted = self.head(seen.states.features).squeeze(-1).float()  # (T, B)
        mask = settled(len(target), data.is_start, self.burn_in).float()
        loss = masked_mean((predicted - target).square(), mask) / 2
        return loss, {"curiosity_target": masked_mean(target, mask),
                      "curiosity_correlation": correlation(predicted.detach(), target, mask)}

    def reward(self, imagined: Imagined) -> Tensor:
        return self.head(imagined.features, imagined.ones).squeeze(-1).float().clamp(min=0)


def settled(steps: int, is_start: Tensor, burn_in: int) -> Tensor:
    """(T, B) bool: false on the first `burn_in` steps of windows that start in mid-episode.

    There the model starts from a zero state, and the KL tells of that and not of the world.
    is_start (B,) bool.
    """
    step = torch.arange(steps, device=is_start.device)
    return (step[:, None] >= burn_in) | is_start[None]


def masked_mean(x: Tensor, mask: Tensor) -> Tensor:
    """Mean of x where mask is one."""
    return (mask * x).sum() / mask.sum().clamp(min=1)


def correlation(x: Tensor, y: Tensor, mask: Tensor) -> Tensor:
    """Pearson's, where mask is one; zero where one of them is constant."""
    x, y = x - masked_mean(x, mask), y - masked_mean(y, mask)
    spread = masked_mean(x * x, mask) * masked_mean(y * y, mask)
    return masked_mean(x * y, mask) / (spread.sqrt() + 1e-8)
