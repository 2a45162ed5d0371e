"""Unrolls: pieces of T steps of an episode, which V-trace learns from B at a time.

Letters: T steps, B unrolls, L layers of the LSTM, U its units, D distinct images of a batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.distinct import distinct

REPEATED = 8


class Unroll(NamedTuple):
    """T steps of an episode and the frame after them."""

    image: np.ndarray  # (T + 1, 64, 64, 3) uint8
    action: np.ndarray  # (T,) int64
    log_policy: np.ndarray  # (T,) float32, log mu(a | s), of the policy that acted
    bonus: np.ndarray  # (T,) float32, the reward's first factor (rewards/reward.py)
    kind: np.ndarray  # (T,) int64, transitions.KINDS
    hidden: np.ndarray  # (L, U) float32, before the first frame
    cell: np.ndarray  # (L, U) float32
    respawned: np.ndarray  # () bool, the last frame begins an episode


class Batch(NamedTuple):
    """B unrolls, time first, on the device."""

    image: Tensor  # (D, 64, 64, 3)
    frame: Tensor  # (T + 1, B), the image of each frame
    action: Tensor  # (T, B)
    log_policy: Tensor  # (T, B)
    bonus: Tensor  # (T, B)
    kind: Tensor  # (T, B)
    hidden: Tensor  # (L, B, U)
    cell: Tensor  # (L, B, U)
    respawned: Tensor  # (B,)


@dataclass
class ActingRecord:
    """What is recorded while acting in an episode: log mu of the actions, the policy's entropy, the LSTM's memory."""

    log_policy: list[float] = field(default_factory=list)
    entropy: list[float] = field(default_factory=list)
    memory: list[tuple[np.ndarray, np.ndarray]] = field(default_factory=list)  # (L, U) before each T-th step


def split_episode(transitions: Transitions, acted: ActingRecord, bonus: np.ndarray, length: int) -> list[Unroll]:
    """Split an episode of N steps with bonus (N,) into N / length unrolls."""
    episode, frames = transitions.episode, np.append(np.arange(len(transitions)), 0)  # the respawn last
    kind, log_policy = transitions.kind, np.array(acted.log_policy, np.float32)
    unrolls = []
    for (hidden, cell), at in zip(acted.memory, range(0, len(episode), length), strict=True):
        steps = slice(at, at + length)
        unrolls.append(Unroll(
            episode.image[frames[at:at + length + 1]], episode.action[steps], log_policy[steps],
            bonus[steps].astype(np.float32), kind[steps], hidden, cell, np.array(at + length == len(episode))))
    return unrolls


def stack_unrolls(unrolls: Sequence[Unroll], device: torch.device) -> Batch:
    """Stack B unrolls, time first, on the device, equal images once.

    Images are repeated up to a multiple of REPEATED, of which no frame makes use: with as many sizes of batches as of
    D, freed memory would not fit the next one, and grow by a third.
    """
    image, *parts = (np.stack(part, axis=min(1, part[0].ndim)) for part in zip(*unrolls, strict=True))
    images = image.reshape(-1, *image.shape[2:])
    first, which = distinct(images)
    repeated = np.resize(first, -(-len(first) // REPEATED) * REPEATED)
    arrays = images[repeated], which.reshape(image.shape[:2]), *parts
    return Batch(*(torch.from_numpy(array).to(device) for array in arrays))
