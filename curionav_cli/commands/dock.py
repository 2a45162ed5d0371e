"""curionav dock: the docking trial, dock.requests episodes that each end with a return to dock.

The agent acts and does not learn. Written are a line of metrics.jsonl for each return (a DockReport), the paper's
table, failures and recoveries by name, and a figure of arrivals.
"""

from __future__ import annotations

import shlex
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config
from curionav_cli.config.search import noted
from curionav_cli.config.sources import COMMAND_DEFAULTS
from curionav_cli.errors import ConfigError
from curionav_cli.execution.docking_trial import DockingTrial, draw
from curionav_cli.execution.launch import Request, launch
from curionav_cli.execution.lifecycle import run_task
from curionav_cli.execution.screen import a_console
from curionav_cli.live.settings import Rosbridge
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.storage.run_folder import RunFolder


def run(request: Request) -> int:
    """Carry out the command; returns the exit code."""
    keys = {word.partition("=")[0] for word in request.overrides}
    chosen = [word for word in COMMAND_DEFAULTS["dock"] if word.partition("=")[0] not in keys]
    return launch(replace(request, overrides=[*chosen, *request.overrides]), work, summary, check,
                  "share of requests that end docked")


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """Carry out one job, as the launchers call it."""
    run = run_task("dock", DockingTrial(settings, folder))
    docked = sum(row["code"] == "docked" for row in run.metrics())
    return {"coverage": docked / settings.dock.requests}  # config.job.OBJECTIVE: the docked share


def check(settings: Config) -> None:
    """Check that the robot docks and that the scene loads. Raises UserError."""
    if isinstance(settings.robot, Rosbridge):
        raise ConfigError("curionav dock is a trial in simulation. A real robot docks between its episodes: "
                          "curionav explore env=live robot=rosbridge")
    if not isinstance(settings.robot, Turtlebot):
        raise ConfigError(f"robot={settings.robot.name} respawns at its start and never docks. "
                          "Choose robot=turtlebot2i.")
    build.scene(settings)
    build.check(settings)


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """Print the last lines of a run or a sweep, also of one that was interrupted."""
    from curionav_cli.commands import summary as end  # matplotlib is loaded once there is something to draw
    from curionav_cli.results import docking

    alone = (folder / "config.yaml").is_file()
    runs = [run for run in ([RunFolder(folder)] if alone else RunFolder.inside(folder)) if docking.came_home(run)]
    if not runs:
        return
    draw(runs, folder)
    console = a_console()
    counted = [trial for part in docking.counted(runs) for trial in part]
    show = partial(end.print_columns, console=console)
    show([docking.summary(trial.where, trial.docks) for trial in counted], docking.TABLE,
         shown=[heading for heading, _, _ in docking.TABLE], caption=docking.BELOW)
    show([row for trial in counted for row in docking.endings(trial.where, trial.docks)], docking.FAILURES,
         shown=[heading for heading, _, _ in docking.FAILURES])
    end.print_files(console, folder, [*sorted(f"figures/{path.name}" for path in folder.glob("figures/*.png")),
                                      "table.md", "results.csv", "endings.csv", "attempts.csv", "metrics.jsonl",
                                      "optimization_results.yaml"])
    longer = "hydra.sweeper.n_trials=..." if "n_trials" in noted(folder) else "dock.requests=..."
    end.print_next(console, [f"curionav resume {shlex.quote(str(folder))} {longer}   (the same, longer)"])
