"""agent.curiosity -> the curiosity: the one that the file of this name defines."""

from __future__ import annotations

from importlib import import_module

from curionav_cli.agents.lbs_dreamer import settings
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity
from curionav_cli.agents.lbs_dreamer.rssm import RSSM


def kind(name: settings.Curiosity) -> type[Curiosity]:
    """The class in the file of this name. Another curiosity is a file here and a line in settings.Curiosity."""
    module = import_module(f"{__package__}.{name.value}")
    found, = (one for one in vars(module).values()
              if isinstance(one, type) and issubclass(one, Curiosity) and one.__module__ == module.__name__)
    return found


def curiosity(hyper: settings.LBSDreamer, rssm: RSSM) -> Curiosity:
    """The chosen one, with heads of the actor's and critic's size."""
    return kind(hyper.curiosity)(rssm, hyper.mlp_units, hyper.mlp_layers, hyper.curiosity_burn_in)
