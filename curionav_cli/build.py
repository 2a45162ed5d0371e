"""Config to objects: the only room that knows everybody. A new agent is one line in AGENTS."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.frontier import Frontier
from curionav_cli.agents.wanderers import Bounce, Random, Sticky
from curionav_cli.config.schema import Config
from curionav_cli.errors import ConfigError
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.motion import HEADINGS
from curionav_cli.world.scene import Scene


def scene(settings: Config) -> Scene:
    """The world at rest. Raises SceneError or MapError."""
    return Scene.from_dict(asdict(settings.env), f"env/{settings.env.name}.yaml")


def env(settings: Config, world: Scene) -> NavigationEnv:
    """The world with a robot in it; robot=ideal respawns."""
    return NavigationEnv(world, engine=settings.env.engine.value)


def check(settings: Config) -> None:
    """Settings that are each possible and together are not. Raises ConfigError."""
    length = getattr(settings.agent, "sequence_length", 0)
    if settings.loop.iterations and length > settings.loop.steps + 1:
        raise ConfigError(f"agent.sequence_length={length} does not fit into an episode of {settings.loop.steps} "
                          f"steps. Set loop.steps={length - 1} or more, or a shorter agent.sequence_length.")


def agent(settings: Config, world: Scene) -> Agent:
    """Who lives in it."""
    return AGENTS[settings.agent.name](settings, world)


def bounce(settings: Config, world: Scene) -> Agent:
    degrees = 360 // HEADINGS
    return Bounce(settings.seed, int(settings.agent.min_turn // degrees), int(settings.agent.max_turn // degrees))


def lbs_dreamer(settings: Config, world: Scene) -> Agent:
    from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer  # torch is loaded for those who learn

    return LBSDreamer(settings.agent, settings.seed, settings.device.value)


AGENTS: dict[str, Callable[[Config, Scene], Any]] = {
    "random": lambda settings, world: Random(settings.seed),
    "sticky": lambda settings, world: Sticky(settings.seed, settings.agent.repeat),
    "bounce": bounce,
    "frontier": lambda settings, world: Frontier(settings.seed, world),
    "lbs_dreamer": lbs_dreamer,
}
