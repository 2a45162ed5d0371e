"""curionav explore: run an agent in an environment; the run folder holds its episodes, metrics and figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.commands import initial
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config, Learner
from curionav_cli.errors import ConfigError
from curionav_cli.execution import keeping, remote_setup
from curionav_cli.execution.exploration import explore
from curionav_cli.execution.launch import Request, launch
from curionav_cli.execution.probing import refuse_of_robot
from curionav_cli.live.settings import Rosbridge


def run(request: Request) -> int:
    """Carry out the command; returns the exit code."""
    return launch(initial.with_agent_of(request), work, summary, check, "coverage")


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """Carry out one job, as the launchers call it."""
    return {"coverage": explore(settings, folder).status["coverage"]}  # config.job.OBJECTIVE


def check(settings: Config) -> None:
    """Check what the schema cannot: that the scene loads and sequences fit into an episode. Raises UserError."""
    if settings.data:
        raise ConfigError("data=... is for curionav train; curionav explore records its own episodes. Leave it out.")
    build.check_reality(settings)
    world = build.world(settings)
    build.check(settings)
    build.refuse_privileged(settings, world)
    initial.check(settings, world)
    build.check_lengths(settings)
    keeping.check(settings, lambda: build.agent(settings, world))
    if isinstance(settings.robot, Rosbridge):
        from curionav_cli.live.connect import refuse_unreachable

        refuse_unreachable(settings.robot)
    if settings.learner is Learner.remote:
        refuse_of_robot(settings)
        remote_setup.check(settings)
    elif settings.storage:
        raise ConfigError("storage=... is for learning in another process. Add learner=remote.")


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """Print the last lines of a run or a sweep, also of one that was interrupted."""
    from curionav_cli.commands.summary import show  # matplotlib is loaded once there is something to draw

    show(folder, [outcome.folder for outcome in outcomes])
