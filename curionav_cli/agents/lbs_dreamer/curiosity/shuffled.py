"""The control of lbs.py: Latent Bayesian Surprise of some other state.

All is as in lbs.py, except that the targets of a batch are permuted at random. The head learns their mean, so whatever
this agent does better than a random walk is not due to its intrinsic reward.
"""

from __future__ import annotations

import torch
from torch import Tensor

from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import settled
from curionav_cli.agents.lbs_dreamer.curiosity.lbs import LBS
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class Shuffled(LBS):
    """LBS with targets permuted among the settled steps of a batch."""

    def target(self, observed: Observed, data: Sequences, noise: Tensor) -> Tensor:
        """The permuted KL: (T, B); steps that are not settled keep out of it."""
        target = super().target(observed, data, noise)
        last = (~settled(len(target), data.is_start, self.burn_in)).float()
        there = last.flatten().argsort(stable=True)
        here = (last + noise / 2).flatten().argsort()
        return torch.zeros_like(target).flatten().scatter(0, there, target.flatten()[here]).view_as(target)
