"""The curiosity that agent.curiosity names: the class that the file of this name defines."""

from __future__ import annotations

from importlib import import_module

from curionav_cli.agents.lbs_dreamer import settings
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Curiosity
from curionav_cli.agents.lbs_dreamer.rssm import RSSM


def kind(name: settings.Curiosity) -> type[Curiosity]:
    """Return the class in the file of this name. Another one is a file here and a line in settings.Curiosity."""
    module = import_module(f"{__package__}.{name.value}")
    curiosity_class, = (value for value in vars(module).values() if isinstance(value, type)
                        and issubclass(value, Curiosity) and value.__module__ == module.__name__)
    return curiosity_class


def curiosity(hyper: settings.LBSDreamer, rssm: RSSM) -> Curiosity:
    """Make the curiosity of the settings, with networks of the actor's and critic's size."""
    return kind(hyper.curiosity)(rssm, hyper.mlp_units, hyper.mlp_layers, hyper.curiosity_burn_in)
