"""The contract of a curiosity, which gives the intrinsic reward, and the regression head that most of them are.

A curiosity is fitted to steps of the replay that the world model has filtered (`loss`), and gives rewards to the states
of imagined rollouts (`intrinsic_reward`), which actor and critic learn from (learner.py, update_behaviour).

Letters: T steps, B sequences, L steps of a window, F features, H horizon, N rollouts.
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


class VisitCounts(Protocol):
    """Counts of visits over all episodes of the replay, for every step of it."""

    def update(self, replay: Replay) -> None:
        """Count the episodes that are new in the replay."""

    def of_windows(self, which: np.ndarray, start: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """Counts (B, L) float32 of windows: episode `which` (B,), first frame `start` (B,), pose (B, L, 3) in metres
        and radians."""


class Curiosity(nn.Module, ABC):
    """Gives the intrinsic reward. No gradient of it reaches the world model.

    rssm: for the sizes of its inputs. units, layers: size of its networks. burn_in: see `settled`.
    """

    def __init__(self, rssm: RSSM, units: int, layers: int, burn_in: int):
        super().__init__()
        self.burn_in = burn_in

    def visit_counts(self, plan: FloorPlan) -> VisitCounts | None:
        """The counts that `loss` needs as `Sequences.counts`; None for none."""
        return None

    @abstractmethod
    def loss(self, observed: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """Scalar loss of its networks, and metrics. observed: (T, B, ...), detached; noise (T, B) uniform in [0, 1)."""

    @abstractmethod
    def intrinsic_reward(self, imagined: Imagined) -> Tensor:
        """Rewards (H + 1, N) float32, none below zero; row i is that of arriving in the imagined state s_i."""

    def of_arriving(self, before: Tensor, action: Tensor, after: Tensor) -> Tensor:
        """Rewards (N,) of N actions (N,) that led from states with features `before` (N, F) to `after` (N, F)."""
        return self.intrinsic_reward(Imagined(torch.stack([before, after]), action[None]))[1]


class Head(Curiosity):
    """An MLP that predicts from a state s_t a number measured on the replay; its prediction is the intrinsic reward."""

    def __init__(self, rssm: RSSM, units: int, layers: int, burn_in: int):
        super().__init__(rssm, units, layers, burn_in)
        self.head = MLP(rssm.features, units, layers, 1, rssm.stoch)

    @abstractmethod
    def target(self, observed: Observed, data: Sequences, noise: Tensor) -> Tensor:
        """The measured numbers (T, B), which the head is fitted to."""

    def loss(self, observed: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """-log N(target; head, 1) without its constant, mean over the settled steps: scalar."""
        target = self.target(observed, data, noise)
        predicted = self.head(observed.states.features).squeeze(-1).float()  # (T, B)
        mask = settled(len(target), data.is_start, self.burn_in).float()
        loss = masked_mean((predicted - target).square(), mask) / 2
        return loss, {"curiosity_target": masked_mean(target, mask),
                      "curiosity_correlation": correlation(predicted.detach(), target, mask)}

    def intrinsic_reward(self, imagined: Imagined) -> Tensor:
        """The head's prediction, clipped at zero."""
        return self.head(imagined.features, imagined.ones).squeeze(-1).float().clamp(min=0)

    def of_arriving(self, before: Tensor, action: Tensor, after: Tensor) -> Tensor:
        """The same, of the states reached alone."""
        return self.head(after).squeeze(-1).float().clamp(min=0)


def settled(steps: int, is_start: Tensor, burn_in: int) -> Tensor:
    """Mask (T, B) bool: false on the first `burn_in` steps of windows that start in mid-episode.

    There the model starts from a zero state, so that the KL measures that and not the world.
    is_start (B,) bool: the window begins where an episode does.
    """
    step = torch.arange(steps, device=is_start.device)
    return (step[:, None] >= burn_in) | is_start[None]


def masked_mean(x: Tensor, mask: Tensor) -> Tensor:
    """Mean of x where mask is one; both of one shape, the result a scalar."""
    return (mask * x).sum() / mask.sum().clamp(min=1)


def correlation(x: Tensor, y: Tensor, mask: Tensor) -> Tensor:
    """Pearson's correlation of x and y where mask is one: a scalar, zero where x or y is constant."""
    x, y = x - masked_mean(x, mask), y - masked_mean(y, mask)
    spread = masked_mean(x * x, mask) * masked_mean(y * y, mask)
    return masked_mean(x * y, mask) / (spread.sqrt() + 1e-8)
