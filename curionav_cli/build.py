"""Config to objects: the only room that knows everybody. A new agent is one line in AGENTS."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, replace
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.baselines import Bounce, Random, Sticky
from curionav_cli.agents.frontier import Frontier
from curionav_cli.agents.lbs_dreamer.settings import Precision
from curionav_cli.config.schema import Compile, Config, Device, Logger, Scale
from curionav_cli.config.sources import AGENTS as SCHEMA
from curionav_cli.errors import ConfigError
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.motion import HEADINGS
from curionav_cli.world.scene.scene import Scene

if TYPE_CHECKING:
    from curionav_cli.robot.env import RobotEnv
    from curionav_cli.robot.return_to_dock import Link

    Environment = NavigationEnv | RobotEnv


def scene(settings: Config) -> Scene:
    """The world at rest. Raises SceneError or MapError, and ConfigError where two worlds are asked for."""
    if settings.env.map and settings.env.size:
        raise ConfigError(f"env.map={settings.env.map} opens a ROS map, and env={settings.env.name} has a size of its "
                          "own. Add env=map.")
    return Scene.from_dict(asdict(settings.env), f"env/{settings.env.name}.yaml")


def env(settings: Config, world: Scene) -> Environment:
    """The world with a robot in it; robot=ideal respawns, the others drive home and dock."""
    return robot_env(settings, world) if isinstance(settings.robot, Turtlebot) else ideal_env(settings, world)


def ideal_env(settings: Config, world: Scene) -> NavigationEnv:
    """Perfect motion."""
    return NavigationEnv(world, engine=settings.env.engine.value)


def robot_env(settings: Config, world: Scene, pictures: bool = True,
              link: Link = lambda server: server) -> RobotEnv:
    """A robot that drifts, drives home and docks; without pictures for agents that do not look."""
    from curionav_cli.robot.env import RobotEnv  # loaded for robots that dock

    return RobotEnv(ideal_env(settings, world), settings.robot, pictures, link)


def check(settings: Config) -> None:
    """Settings that are each possible and together are not. Raises ConfigError."""
    name = settings.agent.name
    if not isinstance(settings.agent, SCHEMA.get(name, ())):
        raise ConfigError(f"agent.name: {name!r} is not the name of this agent; choose an agent with agent=... "
                          f"In a preset of your own keep the name of its schema, one of {', '.join(AGENTS)}.")
    if settings.env.engine.value == "numba" and find_spec("numba") is None:
        raise ConfigError("env.engine=numba needs numba, which is not installed. "
                          "Set env.engine=numpy, or: .venv/bin/pip install -c constraints.txt -e '.[fast]'")
    if settings.logger is Logger.tensorboard and find_spec("tensorboard") is None:
        raise ConfigError("logger=tensorboard needs tensorboard, which is not installed. "
                          "Set logger=local, or: .venv/bin/pip install -c constraints.txt -e '.[tensorboard]'")
    if settings.device is Device.cuda or settings.compile in (Compile.graph, Compile.fused):
        from curionav_cli.agents.device import resolve_device
        from curionav_cli.agents.lbs_dreamer.compile import way

        way(settings.compile.value, resolve_device(settings.device.value))


def check_lengths(settings: Config) -> None:
    """Episodes that are too short to learn from. Raises ConfigError."""
    steps, why = settings.loop.steps, ""
    if isinstance(settings.robot, Turtlebot) and settings.robot.steps < steps:
        steps, why = settings.robot.steps, ", as long as robot.battery lasts"
    length, repeat = getattr(settings.agent, "sequence_length", 0), getattr(settings.agent, "action_repeat", 1)
    if settings.loop.iterations and length > steps // repeat + 1:
        held = f" whose actions are held for {repeat} (agent.action_repeat)" if repeat > 1 else ""
        raise ConfigError(f"agent.sequence_length={length} does not fit into an episode of {steps} steps{why}{held}. "
                          f"Set loop.steps={(length - 1) * repeat} or more, or a shorter agent.sequence_length.")
    unroll = getattr(settings.agent, "unroll", 1)
    if settings.loop.iterations and steps % unroll:
        raise ConfigError(f"agent.unroll={unroll} does not divide an episode of {steps} steps{why}. "
                          f"Set agent.unroll={steps}, or another divisor of {'it' if why else 'loop.steps'}.")


def agent(settings: Config, world: Scene) -> Agent:
    """Who lives in it."""
    return AGENTS[settings.agent.name](settings, world)


def bounce(settings: Config, world: Scene) -> Agent:
    step = 360 // HEADINGS  # degrees
    least, most = settings.agent.min_turn, settings.agent.max_turn
    return Bounce(settings.seed, math.ceil(least / step), max(math.ceil(least / step), math.floor(most / step)))


def lbs_dreamer(settings: Config, world: Scene) -> Agent:
    from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer  # torch is loaded for those who learn

    hyper = with_precision(settings, automatic(settings)).agent
    return LBSDreamer(hyper, settings.seed, settings.device.value, world.plan, settings.compile.value)


def automatic(settings: Config) -> Precision:
    """What agent.precision=auto is, with these settings on this machine; Precision says by which rule."""
    if settings.scale is not Scale.paper:
        return Precision.float32
    from curionav_cli.agents.arithmetic import quick
    from curionav_cli.agents.device import resolve_device

    return quick(resolve_device(settings.device.value).type)


def with_precision(settings: Config, chosen: Precision) -> Config:
    """The settings, with what was chosen for agent.precision=auto."""
    if getattr(settings.agent, "precision", None) is not Precision.auto:
        return settings
    return replace(settings, agent=replace(settings.agent, precision=chosen))


def cbet(settings: Config, world: Scene) -> Agent:
    from curionav_cli.agents.cbet.agent import CBET

    return CBET(settings.agent, settings.seed, settings.device.value, world, settings.env.engine.value)


AGENTS: dict[str, Callable[[Config, Scene], Any]] = {
    "random": lambda settings, world: Random(settings.seed),
    "sticky": lambda settings, world: Sticky(settings.seed, settings.agent.repeat),
    "bounce": bounce,
    "frontier": lambda settings, world: Frontier(settings.seed, world),
    "lbs_dreamer": lbs_dreamer,
    "cbet": cbet,
    "cbet_lifelong": cbet,
}
