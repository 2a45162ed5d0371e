"""curionav explore: an agent lives in a world; its run folder holds all that came of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config, Learner
from curionav_cli.errors import ConfigError
from curionav_cli.execution import remote_setup
from curionav_cli.execution.exploration import explore
from curionav_cli.execution.launch import Request, launch


def run(request: Request) -> int:
    """The command: its exit code."""
    return launch(request, work, summary, check, "coverage")


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """One job, as the launchers call it."""
    return {"coverage": explore(settings, folder).status["coverage"]}  # config.job.OBJECTIVE


def check(settings: Config) -> None:
    """What the schema cannot see: a world that stands, sequences that fit. Raises UserError."""
    if settings.data:
        raise ConfigError("data=... is what curionav train learns from; curionav explore makes its own episodes.")
    build.scene(settings)
    build.check(settings)
    build.check_lengths(settings)
    if settings.learner is Learner.remote:
        remote_setup.check(settings)
    elif settings.storage:
        raise ConfigError("storage=... is where another process learns: add learner=remote.")


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """The last lines of a run or a sweep, also of one that was interrupted."""
    from curionav_cli.commands.summary import show  # matplotlib is loaded once there is something to draw

    show(folder, [outcome.folder for outcome in outcomes])
