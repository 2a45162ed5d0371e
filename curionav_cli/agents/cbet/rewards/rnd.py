"""RND (Burda et al., 2019) as C-BET's authors compare with it: the distance to a fixed random network's features."""

from __future__ import annotations

import torch
import torch.nn.functional as F
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
        with torch.no_grad():
            target = self.networks["target"](batch.image)
        error = F.embedding(batch.frame[1:], self.networks["predictor"](batch.image) - target)
        distance = torch.linalg.vector_norm(error, dim=-1)
        return distance.detach(), self.hyper.rnd_loss * distance.sum(0).mean()
