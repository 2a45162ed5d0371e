"""curionav evaluate RUN...: run a trained agent without learning, in the world it was trained in or in another one.

The agent's settings are those of RUN; the environment, robot and length of episodes too, unless they are given. Several
runs, of equal agents, are evaluated as a sweep.
"""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

from curionav_cli.commands import explore, initial
from curionav_cli.config.job import Outcome
from curionav_cli.config.paths import quoted
from curionav_cli.config.schema import Config, Learner
from curionav_cli.errors import ConfigError
from curionav_cli.execution.evaluation import evaluate
from curionav_cli.execution.launch import Request, launch
from curionav_cli.execution.screen import a_console
from curionav_cli.execution.trained import trained_in
from curionav_cli.places import place
from curionav_cli.storage.run_folder import RunFolder

NEEDS_RUN = "evaluate needs the run whose agent is evaluated: curionav evaluate outputs/DATE/RUN env=apartment_1"


def run(request: Request) -> int:
    """Carry out the command; returns the exit code."""
    if not request.info:
        request = with_settings_of_runs(request)
    return launch(request, work, summary, check, "coverage")


def with_settings_of_runs(request: Request) -> Request:
    """The request with init=RUN and the settings of that run, in place of the folders among its words.

    Raises ConfigError where no run is named or their agents differ, RunFolderError where a run cannot be read.
    """
    request = initial.with_pretrained(request)
    folders = [word for word in request.overrides if "=" not in word]
    words = [word for word in request.overrides if "=" in word]
    keys = initial.keys(words)
    named = initial.folders(words)
    if not folders and not named:
        raise ConfigError(NEEDS_RUN)
    if folders and named:
        raise ConfigError("init=... and a folder name the trained run twice. Leave one out.")
    if not folders and "agent" in keys:  # a command that is given again, by curionav resume
        return request
    own = sorted(key for key in keys if key in ("agent", "scale") or key.startswith("agent."))
    if own:
        raise ConfigError(f"{own[0]}=... is a setting of the trained agent. Leave it out.")
    runs = initial.settings_of(map(place, folders or named))
    first, groups = next(iter(runs.values())), [group for group in ("env", "robot") if group not in keys]
    taken = [*initial.as_words(request, first, groups), f"loop.steps={first.loop.steps}", "loop.iterations=0"]
    return replace(request, multirun=request.multirun or len(runs) > 1, overrides=[
        f"init={','.join(map(quoted, runs))}", *initial.unless_given(taken, keys), *initial.without(words, "init")])


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """Carry out one job, as the launchers call it."""
    return {"coverage": evaluate(settings, folder).status["coverage"]}  # config.job.OBJECTIVE


def check(settings: Config) -> None:
    """Check that there is a trained agent, and that nothing is learned. Raises UserError."""
    if not settings.init:
        raise ConfigError(NEEDS_RUN)
    trained_in(Path(settings.init))
    if settings.loop.iterations:
        raise ConfigError(f"loop.iterations={settings.loop.iterations} would train the agent, and evaluate does not. "
                          f"To go on training: curionav resume {settings.init} loop.episodes=...")
    if settings.learner is Learner.remote:
        raise ConfigError("learner=remote has no meaning for curionav evaluate, which does not learn. Leave it out.")
    explore.check(replace(settings, init=None))


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """Print and write the table of an evaluation or a sweep of them, also of one that was interrupted."""
    from curionav_cli.commands import summary as end  # matplotlib is loaded once there is something to draw
    from curionav_cli.results import evaluations, tables
    from curionav_cli.results.runs import Run, distinguish

    alone = (folder / "config.yaml").is_file()
    runs = [Run(run) for run in ([RunFolder(folder)] if alone else RunFolder.inside(folder))]
    runs = [run for run in runs if run.coverage.steps]
    if not runs:
        return
    distinguish(runs)
    rows = [evaluations.row(run) for run in runs]
    made = ["figures/heatmap.png", "figures/predictions.png"] if alone else end.draw(folder, runs)
    end.write_text(folder / "evaluation.md", tables.markdown(rows, evaluations.COLUMNS, evaluations.BELOW))
    end.write_text(folder / "evaluation.csv", tables.comma_separated(rows))
    console = a_console()
    shown = [heading for heading, key, _ in evaluations.COLUMNS if any(row.get(key) is not None for row in rows)]
    end.print_columns(rows, evaluations.COLUMNS, console, shown, evaluations.BELOW)
    end.print_files(console, folder, [*made, "evaluation.md", "evaluation.csv"])
    quoted_folder = shlex.quote(str(folder))
    end.print_next(console, [f"curionav resume {quoted_folder} loop.episodes={2 * max(row['episodes'] for row in rows)}"
                             "   (the same, longer)",
                             f"curionav compare {quoted_folder}   (intervals over seeds)",
                             f"curionav coverage {shlex.quote(rows[0]['folder'])} film=0,last   (films)"])
