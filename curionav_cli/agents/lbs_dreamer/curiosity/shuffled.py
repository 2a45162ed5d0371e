"""The control: Latent Bayesian Surprise of some other state.

Everything is as in lbs.py, except that the targets of a batch change places at random. The head learns
their mean, so whatever this agent does better than a random walk it does not owe to curiosity.
"""

from __future__ import annotations

import torch
from torch import Tensor

from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import settled
from curionav_cli.agents.lbs_dreamer.curiosity.lbs import LBS
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class Shuffled(LBS):
    """LBS with its targets permuted among the settled steps of a batch."""

    def target(self, seen: Observed, data: Sequences, noise: Tensor) -> Tensor:
        target = super().target(seen, data, noise)
        last = (~settled(len(target), data.is_start, self.burn_in)).float()  # unsettled steps keep out
        there = last.flatten().argsort(stable=True)
        here = (last + noise / 2).flatten().argsort()
        return torch.zeros_like(target).flatten().scatter(0, there, target.flatten()[here]).view_as(target)
