"""Connect to a robot, or say in a line why that is not possible."""

from __future__ import annotations

import socket
import sys
from collections.abc import Callable
from importlib.util import find_spec

from curionav_cli.errors import ConfigError, RunFailed
from curionav_cli.live.clock import WallClock
from curionav_cli.live.dry_run import DryRun
from curionav_cli.live.env import LiveRobot
from curionav_cli.live.safety import Fault
from curionav_cli.live.settings import Rosbridge as Settings
from curionav_cli.live.transport import Transport
from curionav_cli.world.real_floor import RealFloor


def refuse_without_roslibpy() -> None:
    """Raises ConfigError where the extra is not installed."""
    if find_spec("roslibpy") is None:
        raise ConfigError("robot=rosbridge needs roslibpy, which is not installed. "
                          ".venv/bin/pip install -c constraints.txt -e '.[ros]'")


def refuse_unreachable(settings: Settings) -> None:
    """Raises ConfigError where nothing listens at the robot's address."""
    try:
        socket.create_connection((settings.host, settings.port), settings.connect).close()
    except OSError as error:
        raise ConfigError(f"{no_answer(settings)} ({error})") from error


def no_answer(settings: Settings) -> str:
    """What to say where no rosbridge answers."""
    return (f"No rosbridge server answers at ws://{settings.host}:{settings.port} within {settings.connect:g} s. Start "
            "it on the robot (docs/robot-live.md), or say where it is: robot.host=... robot.port=...")


def transport(settings: Settings) -> Transport:
    """Connect to the rosbridge server of the settings. Raises RunFailed where none answers."""
    refuse_without_roslibpy()
    from curionav_cli.live.rosbridge import Rosbridge

    host, port = settings.host, settings.port
    try:
        return Rosbridge(host, port, settings.profile.ros, settings.connect)
    except TimeoutError as error:
        raise RunFailed(no_answer(settings)) from error


def live_robot(settings: Settings, floor: RealFloor, say: Callable[[str], None]) -> LiveRobot:
    """The environment of a real robot, connected. say: prints a line. Raises RunFailed."""
    link = transport(settings)
    try:
        return LiveRobot(floor, settings, DryRun(link, say) if settings.dry_run else link, WallClock(), ask)
    except Fault as fault:
        link.close()
        raise RunFailed(f"The robot cannot be driven: {fault}.") from fault
    except BaseException:
        link.close()
        raise


def ask(what: str) -> None:
    """Ask a person at the terminal to do something. Raises RunFailed where there is no terminal."""
    if not sys.stdin.isatty():
        raise RunFailed(f"{what} Then: curionav resume FOLDER")
    input(f"\n{what} Then press Enter. ")
