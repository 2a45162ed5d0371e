"""ICM (Pathak et al., 2017) as C-BET's authors compare with it: the error of predicting the next image's features."""

from __future__ import annotations

import torch
import torch.nn.functional as F
from torch import Tensor, nn

from curionav_cli.agents.cbet import settings as cbet_settings
from curionav_cli.agents.cbet.network import ImageEncoder
from curionav_cli.agents.cbet.rewards.reward import Reward
from curionav_cli.agents.cbet.unrolls import Batch
from curionav_cli.constants import ACTIONS

HIDDEN = 256


class ICM(Reward):
    """Both losses train the features; no gradient is stopped. Norms are L2, not squared."""

    @staticmethod
    def build(hyper: cbet_settings.CBET) -> nn.ModuleDict:
        encoder = ImageEncoder(hyper.conv_channels)
        size = encoder.features
        return nn.ModuleDict({
            "features": encoder,
            "dynamics": nn.Sequential(nn.Linear(size + len(ACTIONS), HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, size)),
            "inverse": nn.Sequential(nn.Linear(2 * size, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, len(ACTIONS))),
        })

    def learned_bonus(self, batch: Batch) -> tuple[Tensor, Tensor]:
        """The forward error (T, B); loss: forward and inverse errors, weighted, summed over T, mean over B."""
        features = F.embedding(batch.frame, self.networks["features"](batch.image))
        before, after = features[:-1], features[1:]  # (T, B, F)
        action = F.one_hot(batch.action, len(ACTIONS)).to(before)
        predicted = self.networks["dynamics"](torch.cat([before, action], dim=-1))
        inferred = self.networks["inverse"](torch.cat([before, after], dim=-1))
        error = torch.linalg.vector_norm(predicted - after, dim=-1)
        inverse_error = F.cross_entropy(inferred.flatten(0, 1), batch.action.flatten(), reduction="none").view_as(error)
        loss = (self.hyper.forward_loss * error + self.hyper.inverse_loss * inverse_error).sum(0).mean()
        return self.novelty(before, after, error).detach(), loss

    def novelty(self, before: Tensor, after: Tensor, error: Tensor) -> Tensor:
        """The bonus (T, B), from features (T, B, F) of a step's two images and the forward error (T, B)."""
        return error
