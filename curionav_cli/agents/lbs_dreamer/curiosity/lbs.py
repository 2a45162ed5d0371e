"""Latent Bayesian Surprise, equation (2) of the paper.

    r_expl = I(s_{t+1}; x_{t+1} | s_t, a_t) ~ KL[ q(s_{t+1} | s_t, a_t, x_{t+1}) || p(s_{t+1} | s_t, a_t) ]

The intrinsic reward of a transition is the information that its image brings. In imagination there is no x_{t+1}, so a
head learns to predict the KL measured on the replay from the state s_{t+1} reached; its prediction is the reward of
imagined states (as in mastering-urlb).
"""

from __future__ import annotations

from torch import Tensor

from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Head
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class LBS(Head):
    """Expected KL of posterior from dynamics in nats, before free nats and balancing."""

    def target(self, observed: Observed, data: Sequences, noise: Tensor) -> Tensor:
        """KL[q || p] of each step: (T, B)."""
        return latent.kl(observed.posterior, observed.prior)
