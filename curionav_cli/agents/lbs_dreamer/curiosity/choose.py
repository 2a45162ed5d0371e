"""The curiosity that agent.curiosity names: the class that the file of this name defines."""

from __future__ import annotations

from curionav_cli.agents.lbs_dreamer import settings
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity
from curionav_cli.agents.lbs_dreamer.rssm import RSSM
from curionav_cli.agents.one_class import one_class


def kind(name: settings.Curiosity) -> type[Curiosity]:
    """Return the class in the file of this name. Another one is a file here and a line in settings.Curiosity."""
    return one_class(__package__, name.value, Curiosity)  # type: ignore[type-abstract]


def curiosity(hyper: settings.LBSDreamer, rssm: RSSM) -> Curiosity:
    """Make the curiosity of the settings, with networks of the actor's and critic's size."""
    return kind(hyper.curiosity)(rssm, hyper.mlp_units, hyper.mlp_layers, hyper.curiosity_burn_in)
