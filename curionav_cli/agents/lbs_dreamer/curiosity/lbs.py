"""Latent Bayesian Surprise, equation (2) of the paper.

    r_expl = I(s_{t+1}; x_{t+1} | s_t, a_t) ~ KL[ q(s_{t+1} | s_t, a_t, x_{t+1}) || p(s_{t+1} | s_t, a_t) ]

In imagination there is no x_{t+1}, so a head learns the KL that was measured on the replay from the
state that was reached, and imagined rewards are its mean (as mastering-urlb does it).
"""

from __future__ import annotations

from torch import Tensor

from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Head
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class LBS(Head):
    """The state's expected surprise in nats, before free nats and balancing."""

    def target(self, seen: Observed, data: Sequences, noise: Tensor) -> Tensor:
        return latent.kl(seen.posterior, seen.prior)
