"""RND (Burda et al., 2019) as C-BET's authors compare with it: the distance to a fixed random network's features."""

from __future__ import annotations

import torch
from torch import Tensor, nn

from curionav_cli.agents.cbet import settings as cbet_settings
from curionav_cli.agents.cbet.network import ImageEncoder
from curionav_cli.agents.cbet.rewards.reward import Reward
from curionav_cli.agents.cbet.unrolls import Batch


class RND(Reward):
    """Distances are L2 norms, not squared; neither images nor rewards are normalised."""

    @staticmethod
    def build(hyper: cbet_settings.CBET) -> nn.ModuleDict:
        fixed = ImageEncoder(hyper.conv_channels).requires_grad_(False)
        return nn.ModuleDict({"predictor": ImageEncoder(hyper.conv_channels), "target": fixed})

    def learned_bonus(self, batch: Batch) -> tuple[Tensor, Tensor]:
        """The distance (T, B) for the image reached; loss: its weighted sum over T, mean over B."""
        reached = batch.image[1:].flatten(0, 1)
        with torch.no_grad():
            target = self.networks["target"](reached)
        distance = torch.linalg.vector_norm(self.networks["predictor"](reached) - target, dim=-1)
        distance = distance.view_as(batch.bonus)
        return distance.detach(), self.hyper.rnd_loss * distance.sum(0).mean()
