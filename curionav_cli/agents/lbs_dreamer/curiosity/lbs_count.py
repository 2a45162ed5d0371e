"""Latent Bayesian Surprise that wears off with visits, which a robot can measure.

    r = KL[q || p] / sqrt(N(phi(x)))

The KL as in lbs.py, N and phi as in picture_count.py. What remains of the KL after many readings hardly depends on how
often a view was read (docs/paper-length.md); divided by the root of the count it goes on falling.
"""

from __future__ import annotations

from torch import Tensor

from curionav_cli.agents.lbs_dreamer.curiosity.picture_count import PictureCount
from curionav_cli.agents.lbs_dreamer.kernels import latent
from curionav_cli.agents.lbs_dreamer.rssm import Observed
from curionav_cli.agents.lbs_dreamer.world_model import Sequences


class LBSCount(PictureCount):
    """Expected KL of posterior from dynamics in nats, times the bonus of the key of a state's image."""

    def target(self, observed: Observed, data: Sequences, noise: Tensor) -> Tensor:
        """KL[q || p] / sqrt(N) of each step: (T, B)."""
        return latent.kl(observed.posterior, observed.prior) * super().target(observed, data, noise)
