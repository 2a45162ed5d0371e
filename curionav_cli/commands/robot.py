"""curionav robot check PROFILE: what a real robot offers, and what to mend before it explores."""

from __future__ import annotations

from contextlib import closing

from curionav_cli.config.compose import composed
from curionav_cli.config.schema import Config
from curionav_cli.errors import RunFailed
from curionav_cli.execution.interrupts import stoppable
from curionav_cli.execution.screen import a_console, table
from curionav_cli.live import connect
from curionav_cli.live.check import BAD, findings
from curionav_cli.live.safety import Fault
from curionav_cli.world.real_floor import RealFloor
from curionav_cli.world.settings import Live

COLUMNS = (("what", "left"), ("state", "left"), ("name", "left"), ("", "left"))


def settings_of(profile: str, words: list[str]) -> Config:
    """The settings of a robot of this profile. Raises ConfigError."""
    return composed("explore", "env=live", "robot=rosbridge", f"robot/profile={profile}", *words)


def check(profile: str, words: list[str], move: bool) -> int:
    """Check the robot of a profile; words: settings, such as robot.host=... Returns 1 where something is to be mended.

    Raises ConfigError for a wrong setting, RunFailed where the robot does not answer.
    """
    settings = settings_of(profile, words)
    assert isinstance(settings.env, Live)
    console = a_console()
    connect.refuse_unreachable(settings.robot)
    try:
        floor = RealFloor.of(settings.env)
        with stoppable(), closing(connect.live_robot(settings.robot, floor, print)) as robot:
            found = list(findings(robot.base, move))
    except Fault as fault:
        raise RunFailed(f"The robot cannot be checked: {fault}.") from fault
    console.print(table(COLUMNS, [(one.what, one.state, one.name, one.about) for one in found]))
    bad = [one for one in found if one.state in BAD]
    if bad:
        console.print(table((("to mend", "left"), ("", "left")), [(one.what, one.cure) for one in bad]))
    else:
        more = "" if move else " --move also tries two turns and a move."
        line = f"curionav explore env=live robot=rosbridge robot.profile={profile} {' '.join(words)}"
        console.print(f"Nothing to mend.{more} Then: {line}", highlight=False, markup=False, soft_wrap=True)
    return int(bool(bad))
