"""curionav serve: a scene or ROS map as a robot for others, over a rosbridge server.

The simulated robot is that of robot=...; which topics and actions it has, and where the server is, say the settings
that robot=rosbridge has too: robot.profile, robot.host, robot.port, robot.namespace, robot.twist, robot.connect.
The training server is another command: curionav train storage=URL --follow.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from functools import partial

from curionav_cli import build
from curionav_cli.config.compose import composed
from curionav_cli.config.schema import Config
from curionav_cli.errors import ConfigError
from curionav_cli.execution.interrupts import stoppable
from curionav_cli.live import connect
from curionav_cli.live.served.body import ServedBody
from curionav_cli.live.served.pace import Pace
from curionav_cli.live.served.robot import ServedRobot, topics_of
from curionav_cli.live.served.settings import Serving
from curionav_cli.live.settings import Rosbridge
from curionav_cli.live.transport import Transport
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene

OF_LINK = re.compile(r"\+{0,2}robot[./](profile|host|port|namespace|twist|connect)\b")
CHOICE = re.compile(r"^robot\.profile=")  # as Hydra has it: robot/profile=
LINK, WORLD = "robot/profile=turtlebot4", "robot=turtlebot2i"  # unless others are chosen


def run(words: list[str], serving: Serving, names: list[str]) -> int:
    """Serve until interrupted. names: of robots, namespaces within robot.namespace; none: one robot without.

    Raises ConfigError for settings that do not go together, RunFailed where no rosbridge server answers.
    """
    link, world = settings_of(words)
    connect.refuse_unreachable(link)
    say = partial(print, flush=True)
    with stoppable(), closing(connect.transport(link)) as transport:
        robots = served(world, link, serving, names, transport, say)
        for robot in robots:
            introduce(robot, say)
        try:
            Pace(robots, serving.speed, say).run(watching(transport, robots, say))
        except KeyboardInterrupt:
            say("\nstopped")
    return 0


def settings_of(words: list[str]) -> tuple[Rosbridge, Config]:
    """The settings of topics and server, and those of the simulated world, whose camera is the profile's.

    Raises ConfigError.
    """
    of_link = [CHOICE.sub("robot/profile=", word) for word in words if OF_LINK.match(word)]
    of_world = [word for word in words if not OF_LINK.match(word)]
    live = composed("explore", "env=live", "robot=rosbridge", *unless(LINK, of_link), *of_link)
    seen = live.env
    camera = [f"env.{key}={getattr(seen, key)}" for key in ("radius", "camera", "fov")]
    world = composed("explore", *unless(WORLD, of_world), *camera, *of_world)
    check(live.robot, world)
    return live.robot, world


def unless(default: str, words: list[str]) -> list[str]:
    """A default choice, left out where `words` choose."""
    key = default.partition("=")[0]
    return [] if any(word.startswith(f"{key}=") for word in words) else [default]


def check(link: Rosbridge, world: Config) -> None:
    """Raises ConfigError for what cannot be served."""
    if not isinstance(world.robot, Turtlebot):
        raise ConfigError(f"robot={world.robot.name} cannot be served. Choose robot=turtlebot2i, with --exact for one "
                          "without drift.")
    if link.profile.ros == 1 and link.profile.actions():
        by_light = " with robot.profile.dock.name='' here and there it docks by infrared light." * \
            bool(link.profile.dock_ir.name)
        raise ConfigError(f"robot.profile={link.profile.name} is of ROS 1, whose actions are not served:"
                          f"{by_light or ' choose a profile of ROS 2, such as turtlebot4.'}")
    topics_of(link, Serving())
    build.scene(world)


def served(world: Config, link: Rosbridge, serving: Serving, names: list[str], transport: Transport,
           say: Callable[[str], None], epoch: float | None = None) -> list[ServedRobot]:
    """The robots, each in a world of its own with a seed of its own. epoch: the time of stamps; None: now."""
    begins = time.time() if epoch is None else epoch
    return [one(world, replace(link, namespace="/".join(filter(None, (link.namespace, name)))), serving,
                world.seed + at, transport, say, begins) for at, name in enumerate(names or [""])]


def one(world: Config, link: Rosbridge, serving: Serving, seed: int, transport: Transport,
        say: Callable[[str], None], epoch: float) -> ServedRobot:
    scene: Scene = build.scene(world).at(0, seed)[0]
    body = ServedBody(scene, world.robot, serving, seed, docked=link.profile.has_dock)
    return ServedRobot(body, Renderer(scene, world.env.engine.value), link, serving, transport, epoch, say)


def introduce(robot: ServedRobot, say: Callable[[str], None]) -> None:
    """Say what is served."""
    link = robot.link
    say(f"{link.profile.name} at ws://{link.host}:{link.port}: {' '.join(sent.name for sent in robot.sent)}")
    say(f"  listens to {robot.commands} and to the actions "
        f"{' '.join(action.name for action in link.profile.actions().values()) or '(none)'}. Ctrl-C ends it.")


def watching(transport: Transport, robots: list[ServedRobot], say: Callable[[str], None]) -> Callable[[], None]:
    """Say when the connection is lost and when it is there again, and what the server refuses."""
    names, said, alive = [name for robot in robots for name in robot.names()], set[str](), [True]

    def watch() -> None:
        now = transport.is_alive()
        if now != alive[0]:
            say("connected again" if now else "the connection is lost; waiting for the server")
        alive[0] = now
        for name in names:
            if name not in said and transport.complaint(name):
                said.add(name)
                say(f"{name} is not served; the server says: {transport.complaint(name)}")
    return watch
