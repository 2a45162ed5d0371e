"""Unrolls: T steps of an episode as V-trace learns from them. They wait in a queue until B of them are there.

Letters: T steps, B unrolls, L layers of the LSTM, U its units.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from curionav_cli.agents.cbet.transitions import Transitions


class Unroll(NamedTuple):
    """One piece of an episode."""

    image: np.ndarray  # (T + 1, 64, 64, 3) uint8
    action: np.ndarray  # (T,) int64
    log_policy: np.ndarray  # (T,) float32, log mu of the action when it was taken
    bonus: np.ndarray  # (T,) float32, the reward's first factor
    kind: np.ndarray  # (T,) int64, life.KINDS
    hidden: np.ndarray  # (L, U) float32, before the first frame
    cell: np.ndarray  # (L, U) float32
    respawned: np.ndarray  # () bool, the last frame begins an episode


class Batch(NamedTuple):
    """B unrolls, time first, on the device."""

    image: Tensor  # (T + 1, B, 64, 64, 3)
    action: Tensor  # (T, B)
    log_policy: Tensor  # (T, B)
    bonus: Tensor  # (T, B)
    kind: Tensor  # (T, B)
    hidden: Tensor  # (L, B, U)
    cell: Tensor  # (L, B, U)
    respawned: Tensor  # (B,)


@dataclass
class Acted:
    """What only the acting agent knows of an episode: how likely its actions were, and its memory now and then."""

    log_policy: list[float] = field(default_factory=list)
    entropy: list[float] = field(default_factory=list)
    memory: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)  # (L, U) before each T-th step


def cut(life: Transitions, acted: Acted, bonus: np.ndarray, length: int) -> list[Unroll]:
    """An episode of N steps as N / length unrolls."""
    frames = np.append(np.arange(len(life)), 0)  # of the episode, the respawn last
    kind, log_policy = life.kind, np.array(acted.log_policy, np.float32)
    unrolls = []
    for (hidden, cell), at in zip(acted.memory, range(0, len(life), length), strict=True):
        steps = slice(at, at + length)
        unrolls.append(Unroll(
            life.episode.image[frames[at:at + length + 1]], life.episode.action[steps], log_policy[steps],
            bonus[steps].astype(np.float32), kind[steps], hidden, cell, np.array(at + length == len(life))))
    return unrolls


def together(unrolls: Sequence[Unroll], device: torch.device) -> Batch:
    """Unrolls side by side."""
    parts = [torch.from_numpy(np.stack(part, axis=min(1, part[0].ndim))) for part in zip(*unrolls, strict=True)]
    return Batch(*(part.to(device) for part in parts))
