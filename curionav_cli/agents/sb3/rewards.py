"""Intrinsic rewards of an episode: agent.reward=count and rnd.

Letters: T steps of an episode, F features.
"""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor, nn

from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.network import ImageEncoder
from curionav_cli.agents.cbet.rms import RunningRMS
from curionav_cli.agents.image_hash import StateKeys
from curionav_cli.agents.sb3.settings import SB3
from curionav_cli.agents.sb3.settings import Reward as Names
from curionav_cli.records import Episode


class Reward(nn.Module):
    """The contract. counts: what it counted; optimiser: of networks that learn; both are saved with the agent."""

    counts: Counts | None = None
    optimiser: torch.optim.Optimizer | None = None

    def rewards(self, episode: Episode) -> np.ndarray:
        """The reward of each step (T,) float32, and learn from the episode."""
        raise NotImplementedError


class Count(Reward):
    """1 / sqrt(N) of the image that a step reached, N counted over the whole run."""

    def __init__(self, own: SB3, rng: np.random.Generator):
        super().__init__()
        self.keys = StateKeys(own.key.value, own.key_bits, rng)
        self.counts = self.table = Counts(1)

    def rewards(self, episode: Episode) -> np.ndarray:
        count = np.array([self.table.add(0, key) for key in self.keys(episode.image[1:])])
        return (count**-0.5).astype(np.float32)


class RND(Reward):
    """Random network distillation (Burda et al., 2019): the distance of features, divided by its running size."""

    def __init__(self, own: SB3, rng: np.random.Generator):
        super().__init__()
        self.predictor = ImageEncoder(own.conv_channels)
        self.target = ImageEncoder(own.conv_channels).requires_grad_(False)
        self.rms, self.batch = RunningRMS(own.rms_momentum), own.rnd_batch
        self.optimiser = self.adam = torch.optim.Adam(self.predictor.parameters(), lr=own.rnd_lr)

    def rewards(self, episode: Episode) -> np.ndarray:
        """Each batch is rewarded before the predictor learns from it."""
        images = torch.from_numpy(episode.image[1:]).to(next(self.parameters()).device)
        distance = torch.cat([self.distance(part) for part in images.split(self.batch)])
        return (distance / self.rms(distance)).cpu().numpy()

    def distance(self, images: Tensor) -> Tensor:
        """The distance (n,) of the features (n, F) of images (n, 64, 64, 3), and one step of the predictor."""
        with torch.no_grad():
            target = self.target(images)
        distance = torch.linalg.vector_norm(self.predictor(images) - target, dim=-1)
        self.adam.zero_grad()
        distance.mean().backward()
        self.adam.step()
        return distance.detach()


REWARDS: dict[Names, type[Count] | type[RND]] = {Names.count: Count, Names.rnd: RND}
