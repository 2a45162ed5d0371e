"""No curiosity: what the entropy bonus alone makes of the actor."""

from __future__ import annotations

from torch import Tensor

from curionav_cli.agents.lbs_dreamer.behaviour import Imagined
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class Indifferent(Curiosity):
    """Every state is worth nothing."""

    def loss(self, seen: Observed, data: Sequences, noise: Tensor) -> tuple[Tensor, dict[str, Tensor]]:
        return noise.sum() * 0, {}

    def reward(self, imagined: Imagined) -> Tensor:
        return imagined.features.new_zeros(imagined.features.shape[:2]).float()
