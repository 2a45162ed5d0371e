"""Build the scene, the environment and the agent of a config, and refuse settings that do not go together."""

from __future__ import annotations

from dataclasses import asdict, replace
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.lbs_dreamer.settings import Precision
from curionav_cli.agents.registry import AGENTS
from curionav_cli.agents.setup import Setup
from curionav_cli.config.schema import Compile, Config, Device, Scale
from curionav_cli.errors import ConfigError
from curionav_cli.live.settings import Rosbridge
from curionav_cli.options import chosen
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.storage import loggers
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.real_floor import RealFloor
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.settings import Live

if TYPE_CHECKING:
    from curionav_cli.live.env import LiveRobot
    from curionav_cli.robot.env import RobotEnv
    from curionav_cli.robot.return_to_dock import Link

    Environment = NavigationEnv | RobotEnv | LiveRobot

World = Scene | RealFloor


def world(settings: Config) -> World:
    """Build the scene, or what is known of a real floor. Raises SceneError, MapError or ConfigError."""
    return RealFloor.of(settings.env) if isinstance(settings.env, Live) else scene(settings)


def scene(settings: Config) -> Scene:
    """Build the scene. Raises SceneError or MapError, and ConfigError where there is none, or a map beside another."""
    if isinstance(settings.env, Live):
        raise ConfigError(f"env={settings.env.name} is a real floor, of which there is no scene. Choose another env.")
    if settings.env.map and settings.env.size:
        raise ConfigError(f"env.map={settings.env.map} opens a ROS map, and env={settings.env.name} has a size of its "
                          "own. Add env=map.")
    return Scene.from_dict(asdict(settings.env), f"env/{settings.env.name}.yaml")


def env(settings: Config, world: World) -> Environment:
    """Build the environment: robot=ideal respawns at reset, the others return to their dock. A real robot is connected
    to; raises RunFailed where it does not answer."""
    if isinstance(world, RealFloor):
        from curionav_cli.live.connect import live_robot

        return live_robot(settings.robot, world, partial(print, flush=True))
    return robot_env(settings, world) if isinstance(settings.robot, Turtlebot) else ideal_env(settings, world)


def ideal_env(settings: Config, world: Scene) -> NavigationEnv:
    """Build the environment of a robot with perfect motion."""
    return NavigationEnv(world, engine=settings.env.engine.value)


def robot_env(settings: Config, world: Scene, pictures: bool = True,
              link: Link = lambda server: server) -> RobotEnv:
    """Build the environment of a robot with odometry drift that returns to its dock.

    pictures: whether observations have images. link: what stands between the robot and its docking server.
    """
    from curionav_cli.robot.env import RobotEnv  # slow to import, and only docking robots need it

    return RobotEnv(ideal_env(settings, world), settings.robot, pictures, link)


def check(settings: Config) -> None:
    """Refuse settings that are each valid and together are not. Raises ConfigError."""
    name = settings.agent.name
    if name not in AGENTS or not isinstance(settings.agent, AGENTS[name].settings):
        raise ConfigError(f"agent.name: {name!r} is not the name of this agent; choose an agent with agent=... "
                          f"In a preset of your own keep the name of its schema, one of {', '.join(AGENTS)}.")
    missing = AGENTS[name].missing(settings.agent)
    if missing:
        raise ConfigError(missing)
    if settings.env.engine.value == "numba" and find_spec("numba") is None:
        raise ConfigError("env.engine=numba needs numba, which is not installed. "
                          "Set env.engine=numpy, or: .venv/bin/pip install -c constraints.txt -e '.[fast]'")
    if lacking := loggers.missing(settings.loggers):
        raise ConfigError(lacking)
    if settings.device is Device.cuda or settings.compile in (Compile.graph, Compile.fused):
        from curionav_cli.agents.device import resolve_device
        from curionav_cli.agents.lbs_dreamer.compile import compile_mode

        compile_mode(settings.compile.value, resolve_device(settings.device.value))


def check_reality(settings: Config) -> None:
    """Refuse a real robot in a simulated world, a simulated one on a real floor, and what no robot can do there.

    Raises ConfigError.
    """
    real, live = isinstance(settings.robot, Rosbridge), isinstance(settings.env, Live)
    if live and not real:
        raise ConfigError(f"env={settings.env.name} is a real floor, and robot={settings.robot.name} is simulated. "
                          "Choose robot=rosbridge.")
    if real and not live:
        raise ConfigError(f"robot={settings.robot.name} is a real robot, and env={settings.env.name} is simulated. "
                          "Choose env=live.")
    if real:
        from curionav_cli.live.connect import refuse_without_roslibpy

        refuse_without_roslibpy()


def check_lengths(settings: Config) -> None:
    """Refuse episodes that are too short to learn from. Raises ConfigError."""
    steps, why = settings.loop.steps, ""
    if isinstance(settings.robot, Turtlebot) and settings.robot.steps < steps:
        steps, why = settings.robot.steps, ", as long as robot.battery lasts"
    length, every = getattr(settings.agent, "sequence_length", 0), chosen(asdict(settings.agent))
    if settings.loop.iterations and length > steps // every.most + 1:
        lasting = f" whose {every.lasting}" if every.most > 1 else ""
        raise ConfigError(f"agent.sequence_length={length} does not fit into an episode of {steps} steps{why}"
                          f"{lasting}. Set loop.steps={(length - 1) * every.most} or more, or a shorter "
                          "agent.sequence_length.")
    unroll = getattr(settings.agent, "unroll", 1)
    if settings.loop.iterations and steps % unroll:
        raise ConfigError(f"agent.unroll={unroll} does not divide an episode of {steps} steps{why}. "
                          f"Set agent.unroll={steps}, or another divisor of {'it' if why else 'loop.steps'}.")


def agent(settings: Config, world: World) -> Agent:
    """Build the agent; world: the scene or floor that it acts in. Raises ConfigError for one that needs a scene."""
    refuse_privileged(settings, world)
    if getattr(settings.agent, "precision", None) is Precision.auto:
        settings = with_precision(settings, automatic(settings))
    setup = Setup(settings.seed, settings.device.value, settings.compile.value, settings.env.engine.value, world)
    return AGENTS[settings.agent.name].make(settings.agent, setup)


def refuse_privileged(settings: Config, world: World) -> None:
    """Raises ConfigError for an agent that needs a scene on a real floor."""
    needs = AGENTS[settings.agent.name].privileged(settings.agent)
    if needs and isinstance(world, RealFloor):
        raise ConfigError(f"{needs}: env={settings.env.name} is a real floor, of which there is no scene.")


def automatic(settings: Config) -> Precision:
    """The precision that agent.precision=auto stands for on this machine, by the rule that Precision states."""
    if settings.scale is not Scale.paper:
        return Precision.float32
    from curionav_cli.agents.arithmetic import quick
    from curionav_cli.agents.device import resolve_device

    return quick(resolve_device(settings.device.value).type)


def with_precision(settings: Config, chosen: Precision) -> Config:
    """The settings with `chosen` in place of agent.precision=auto; others are returned as they are."""
    if getattr(settings.agent, "precision", None) is not Precision.auto:
        return settings
    return replace(settings, agent=replace(settings.agent, precision=chosen))
