"""curionav train: an agent learns from stored episodes, without living; its run folder is that of a life without one.

loop.iterations are all iterations together. A save follows every hundredth, the K of the paper, as one
follows every episode of a life.
"""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.commands import summary as end
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config, Learner
from curionav_cli.errors import ConfigError
from curionav_cli.execution import remote_setup
from curionav_cli.execution.launch import Request, launch
from curionav_cli.execution.screen import a_console
from curionav_cli.execution.serving import serve
from curionav_cli.execution.training import train
from curionav_cli.storage import episodes
from curionav_cli.storage.run_folder import RunFolder


def run(request: Request) -> int:
    """The command: its exit code. --follow is the one setting that has a word of its own."""
    words = ["remote.follow=true" if word == "--follow" else word for word in request.overrides]
    return launch(replace(request, overrides=words), work, summary, check)


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """One job, as the launchers call it."""
    (serve if settings.storage else train)(settings, folder)
    return {}


def check(settings: Config) -> None:
    """What the schema cannot see: episodes that an agent can learn from. Raises UserError."""
    if settings.storage:
        check_server(settings)
        return
    if not settings.data:
        raise ConfigError("train needs data, the folder of a run, of a sweep, or of episodes: "
                          "curionav train data=outputs/DATE/RUN; or a robot's storage: "
                          "curionav train storage=file:///DIR --follow")
    if not settings.loop.iterations:
        raise ConfigError("loop.iterations=0 trains nothing.")
    build.check(settings)
    data = Path(settings.data)
    names = episodes.names(data)
    lived_in = episodes.environments(data)
    if lived_in and settings.env.name not in lived_in:
        raise ConfigError(f"data: {data} was lived in {lived_in[0]}, not in {settings.env.name}. "
                          f"Add env={lived_in[0]}.")
    agent = build.agent(settings, build.scene(settings))
    if not agent.learns or agent.on_policy:
        why = "learns only from what it has just lived" if agent.learns else "does not learn"
        raise ConfigError(f"agent={settings.agent.name} {why}, so stored episodes cannot train it. "
                          "They can train agent=lbs_dreamer.")
    length, most = getattr(settings.agent, "sequence_length", 0), episodes.longest(data, names, agent.every)
    if length > most + 1:
        held = f" held for {agent.every} steps" if agent.every > 1 else ""
        raise ConfigError(f"agent.sequence_length={length} does not fit into the longest episode of {data}, "
                          f"{most} actions{held}. Set agent.sequence_length={most + 1} or less"
                          f"{', or a shorter agent.action_repeat' if held else ''}.")


def check_server(settings: Config) -> None:
    """A storage is all that a server learns from. Raises UserError."""
    if settings.data:
        raise ConfigError("data=... and storage=... are two places to learn from. Give one of them.")
    if settings.learner is Learner.remote:
        raise ConfigError("curionav train learns here: learner=remote is for the robot, curionav explore.")
    build.check(settings)
    build.check_lengths(settings)
    remote_setup.check(settings)


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """The last lines of a training or a sweep of them, also of one that was interrupted."""
    runs = [RunFolder(folder)] if (folder / "config.yaml").is_file() else RunFolder.inside(folder)
    console = a_console()
    for one in runs:
        status = one.status
        used = status.get("replay", {})
        done = f"iteration {status.get('iteration')} of {status.get('iterations')}" if "iteration" in status else \
            f"weights {status.get('episode')}"
        console.print(f"{one.path.name}: {status.get('state')}, {done}, {used.get('episodes')} episodes, "
                      f"{used.get('steps')} steps", soft_wrap=True, highlight=False, markup=False)
        end.print_files(console, one.path, ("metrics.jsonl", "checkpoint"))
    if runs:
        on = f"curionav resume {shlex.quote(str(folder))}"
        served = (runs[0].path / "ledger.sqlite").is_file()
        end.print_next(console, [f"{on}   (goes on serving)" if served else
                                 f"{on} loop.iterations=...   (the same training, longer)"])
