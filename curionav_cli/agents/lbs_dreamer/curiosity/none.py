"""No intrinsic reward: the actor learns from the entropy bonus alone."""

from __future__ import annotations

from torch import Tensor

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class Indifferent(Curiosity):
    """A reward of zero everywhere."""

    def loss(self, observed: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        """A loss of zero."""
        return noise.sum() * 0, {}

    def intrinsic_reward(self, imagined: Imagined) -> Tensor:
        """Zeros (H + 1, N)."""
        return imagined.features.new_zeros(imagined.features.shape[:2]).float()
