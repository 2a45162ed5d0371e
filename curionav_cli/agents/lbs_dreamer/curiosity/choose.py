"""agent.curiosity -> the curiosity."""

from __future__ import annotations

from collections.abc import Callable

from curionav_cli.agents.lbs_dreamer import settings as lbs_settings
from curionav_cli.agents.lbs_dreamer.curiosity.count import Count
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity
from curionav_cli.agents.lbs_dreamer.curiosity.disagreement import Disagreement
from curionav_cli.agents.lbs_dreamer.curiosity.lbs import LBS
from curionav_cli.agents.lbs_dreamer.curiosity.none import Indifferent
from curionav_cli.agents.lbs_dreamer.curiosity.picture_count import PictureCount
from curionav_cli.agents.lbs_dreamer.curiosity.rnd import RND
from curionav_cli.agents.lbs_dreamer.curiosity.shuffled import Shuffled
from curionav_cli.agents.lbs_dreamer.rssm import RSSM

CURIOSITIES: dict[str, Callable[..., Curiosity]] = {
    "lbs": LBS, "picture_count": PictureCount, "disagreement": Disagreement, "rnd": RND, "count": Count,
    "shuffled": Shuffled, "none": Indifferent,
}


def curiosity(hyper: lbs_settings.LBSDreamer, rssm: RSSM) -> Curiosity:
    """The chosen one, with heads of the actor's and critic's size."""
    return CURIOSITIES[hyper.curiosity.value](rssm, hyper.mlp_units, hyper.mlp_layers, hyper.curiosity_burn_in)
