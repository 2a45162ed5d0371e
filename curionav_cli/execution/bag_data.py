"""The episodes that data=... names: of runs and folders, and of bags, which are first made into episodes."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from curionav_cli.bags import cache as kept
from curionav_cli.bags import source
from curionav_cli.bags.library import refuse_without_rosbags
from curionav_cli.config.schema import Config
from curionav_cli.execution.progress import say
from curionav_cli.live.settings import Rosbridge


def folder_of(settings: Config) -> Path:
    """The folder with the episodes of data=...; what became of bags is said once. Raises UserError."""
    data = Path(settings.data or "")
    bags = kept.found(data)
    if not bags:
        return data
    refuse_without_rosbags()
    robot = settings.robot
    sources = [source.of(robot.profile, robot.namespace)] if isinstance(robot, Rosbridge) else source.known()
    folder = kept.converted(bags, sources)
    tell(folder)
    return folder


@cache
def tell(folder: Path) -> None:
    """Say what became of the bags whose episodes are in a folder."""
    for line in kept.report(folder):
        say(line)
