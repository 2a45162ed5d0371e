"""The agents by name. Another agent is a module or folder here, conf/agent/NAME.yaml, and a line in AGENTS.

`make(own, setup)` gets the agent's own settings and imports heavy libraries when it is called, so that --help stays
quick.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, fields
from typing import TYPE_CHECKING, Any, NamedTuple

from curionav_cli.agents import cbet, curious_mapper, lbs_dreamer, mapper, sb3, settings
from curionav_cli.agents.cbet.settings import CBET, CBETLifelong
from curionav_cli.agents.curious_mapper.settings import CuriousMapper
from curionav_cli.agents.lbs_dreamer.settings import LBSDreamer
from curionav_cli.agents.mapper.settings import Mapper
from curionav_cli.agents.sb3.settings import SB3
from curionav_cli.agents.setup import Setup

if TYPE_CHECKING:
    from curionav_cli.agents.agent import Agent


class Registered(NamedTuple):
    """The dataclass of an agent's settings, and the function that makes the agent from them.

    privileged: what of its settings needs a scene, which a real floor has not, with the cure; empty where nothing does.
    missing: what it needs and is not installed, with the cure; empty where nothing is missing.
    """

    settings: type
    make: Callable[[Any, Setup], Agent]
    privileged: Callable[[Any], str] = lambda own: ""
    missing: Callable[[Any], str] = lambda own: ""


def random(own: settings.Random, setup: Setup) -> Agent:
    from curionav_cli.agents.baselines import Random
    from curionav_cli.options import chosen

    return Random(setup.seed, chosen(asdict(own)))


def sticky(own: settings.Sticky, setup: Setup) -> Agent:
    from curionav_cli.agents.baselines import Sticky

    return Sticky(setup.seed, own.repeat)


def bounce(own: settings.Bounce, setup: Setup) -> Agent:
    from curionav_cli.agents.baselines import Bounce

    return Bounce.turning(setup.seed, own.min_turn, own.max_turn)


def frontier(own: settings.Frontier, setup: Setup) -> Agent:
    from curionav_cli.agents.frontier import Frontier
    from curionav_cli.world.scene.scene import Scene

    assert isinstance(setup.scene, Scene)  # see privileged
    return Frontier(setup.seed, setup.scene)


def oracle(own: settings.Frontier) -> str:
    return "agent=frontier is an oracle that is given the map. Choose agent=mapper, which draws its own"


AGENTS: dict[str, Registered] = {
    "random": Registered(settings.Random, random),
    "sticky": Registered(settings.Sticky, sticky),
    "bounce": Registered(settings.Bounce, bounce),
    "frontier": Registered(settings.Frontier, frontier, oracle),
    "mapper": Registered(Mapper, mapper.make),
    "curious_mapper": Registered(CuriousMapper, curious_mapper.make),
    "lbs_dreamer": Registered(LBSDreamer, lbs_dreamer.make),
    "cbet": Registered(CBET, cbet.make, cbet.privileged),
    "cbet_lifelong": Registered(CBETLifelong, cbet.make, cbet.privileged),
    "sb3": Registered(SB3, sb3.make, missing=sb3.missing),
}


def unread(settings: type | None) -> frozenset[str]:
    """The settings that an agent shares with another and does not read itself: its UNREAD."""
    return getattr(settings, "UNREAD", frozenset())


def readers(name: str) -> list[str]:
    """The agents that read a setting of this name."""
    return [agent for agent, one in AGENTS.items()
            if name in {field.name for field in fields(one.settings)} - unread(one.settings)]
