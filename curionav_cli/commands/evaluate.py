"""curionav evaluate RUN...: run a trained agent without learning, in the world it was trained in or in another one.

The agent's settings are those of RUN; the environment, robot and length of episodes too, unless they are given. Several
runs, of equal agents, are evaluated as a sweep.
"""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from curionav_cli.commands import explore
from curionav_cli.config.compose import composed
from curionav_cli.config.job import Outcome
from curionav_cli.config.paths import quoted
from curionav_cli.config.schema import Config, Learner
from curionav_cli.config.settings import read_settings, settings_yaml
from curionav_cli.errors import ConfigError
from curionav_cli.execution.evaluation import evaluate, trained_in
from curionav_cli.execution.launch import Request, launch
from curionav_cli.execution.screen import a_console
from curionav_cli.places import place
from curionav_cli.storage.run_folder import RunFolder

NEEDS_RUN = "evaluate needs the run whose agent is evaluated: curionav evaluate outputs/DATE/RUN env=apartment_1"


def run(request: Request) -> int:
    """Carry out the command; returns the exit code."""
    if not request.info:
        request = with_settings_of_runs(request)
    return launch(request, work, summary, check, "coverage")


def with_settings_of_runs(request: Request) -> Request:
    """The request with weights=RUN and the settings of that run, in place of the folders among its words.

    Raises ConfigError where no run is named or their agents differ, RunFolderError where a run cannot be read.
    """
    folders = [word for word in request.overrides if "=" not in word]
    words = [word for word in request.overrides if "=" in word]
    keys = {word.partition("=")[0].lstrip("+~") for word in words}
    if not folders and "weights" not in keys:
        raise ConfigError(NEEDS_RUN)
    if not folders:  # a command that is given again, by curionav resume
        return request
    own = sorted(key for key in keys if key in ("agent", "scale") or key.startswith("agent."))
    if "weights" in keys:
        raise ConfigError("weights=... and a folder name the trained run twice. Leave one out.")
    if own:
        raise ConfigError(f"{own[0]}=... is a setting of the trained agent. Leave it out.")
    runs = {str(place(folder).resolve()): read_settings(trained_in(place(folder)).config) for folder in folders}
    first, *others = runs.values()
    for path, settings in runs.items():
        if (settings.agent, settings.scale) != (first.agent, first.scale):
            raise ConfigError(f"{path} has an agent of other settings than {next(iter(runs))}. "
                              "Evaluate them one after the other.")
    chosen = f"weights={','.join(map(quoted, runs)) if others else quoted(next(iter(runs)))}"
    return replace(request, overrides=[chosen, *as_words(first, keys), *words],
                   multirun=request.multirun or bool(others))


def as_words(settings: Config, given: set[str]) -> list[str]:
    """The settings of a run as overrides, but for groups that are given: [agent=..., agent.lr=..., env=...].

    Of a group only what differs from its file is among them.
    """
    groups = ["agent", *(group for group in ("env", "robot") if group not in given)]
    words = [f"scale={settings.scale.value}", *(f"{group}={getattr(settings, group).name}" for group in groups),
             f"loop.steps={settings.loop.steps}", "loop.iterations=0"]
    recorded, files = plain(settings), plain(composed("evaluate", *words))
    return [word for word in words if word.partition("=")[0] not in given] + [
        f"{key}={value}" for group in groups for key, value in leaves(recorded[group], group).items()
        if value != leaves(files[group], group).get(key) and key not in given]


def plain(settings: Config) -> dict[str, Any]:
    """Nested dictionaries of plain values."""
    return yaml.safe_load(settings_yaml(settings))


def leaves(settings: dict[str, Any], prefix: str) -> dict[str, str]:
    """Dotted keys with their values as Hydra's grammar has them; lists stay whole."""
    found: dict[str, str] = {}
    for key, value in settings.items():
        found |= leaves(value, f"{prefix}.{key}") if isinstance(value, dict) else {f"{prefix}.{key}": literal(value)}
    return found


def literal(value: Any) -> str:
    """A value in Hydra's grammar: text in quotes, lists and dictionaries by their items."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, list):
        return f"[{','.join(map(literal, value))}]"
    if isinstance(value, dict):
        return "{" + ",".join(f"{key}:{literal(item)}" for key, item in value.items()) + "}"
    return json.dumps(value)


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """Carry out one job, as the launchers call it."""
    return {"coverage": evaluate(settings, folder).status["coverage"]}  # config.job.OBJECTIVE


def check(settings: Config) -> None:
    """Check that there is a trained agent, and that nothing is learned. Raises UserError."""
    if not settings.weights:
        raise ConfigError(NEEDS_RUN)
    trained_in(Path(settings.weights))
    if settings.loop.iterations:
        raise ConfigError(f"loop.iterations={settings.loop.iterations} would train the agent, and evaluate does not. "
                          f"To go on training: curionav resume {settings.weights} loop.episodes=...")
    if settings.learner is Learner.remote:
        raise ConfigError("learner=remote has no meaning for curionav evaluate, which does not learn. Leave it out.")
    explore.check(replace(settings, weights=None))


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
