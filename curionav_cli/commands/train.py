"""curionav train: offline training on stored episodes, or training as the learner of a remote robot.

loop.iterations is the total. A checkpoint follows every hundredth iteration, the K of the paper, as it follows every
episode of an exploration.
"""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.commands import initial
from curionav_cli.commands.summary import print_files, print_next
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config, Learner
from curionav_cli.errors import ConfigError
from curionav_cli.execution import keeping, remote_setup
from curionav_cli.execution.bag_data import folder_of
from curionav_cli.execution.launch import Request, launch
from curionav_cli.execution.screen import a_console
from curionav_cli.execution.serving import serve
from curionav_cli.execution.training import train
from curionav_cli.files import read_json
from curionav_cli.storage import episodes
from curionav_cli.storage.run_folder import RunFolder


def run(request: Request) -> int:
    """Carry out the command; returns the exit code. --follow stands for remote.follow=true."""
    words = ["remote.follow=true" if word == "--follow" else word for word in request.overrides]
    return launch(initial.with_agent_of(replace(request, overrides=words)), work, summary, check)


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """Carry out one job, as the launchers call it."""
    (serve if settings.storage else train)(settings, folder)
    return {}


def check(settings: Config) -> None:
    """Check what the schema cannot: that the agent can learn from the episodes. Raises UserError."""
    if settings.storage:
        check_server(settings)
        return
    if not settings.data:
        raise ConfigError("train needs data, the folder of a run, of a sweep, or of episodes: "
                          "curionav train data=outputs/DATE/RUN; or a robot's storage: "
                          "curionav train storage=file:///DIR --follow")
    if not settings.loop.iterations:
        raise ConfigError("loop.iterations=0 trains nothing. Set it to 1 or more.")
    build.check(settings)
    data = folder_of(settings)
    names = episodes.names(data)
    recorded_in = episodes.environments(data)
    if recorded_in and settings.env.name not in recorded_in:
        raise ConfigError(f"data: {data} was recorded in {recorded_in[0]}, not in {settings.env.name}. "
                          f"Add env={recorded_in[0]}.")
    world = build.world(settings)
    initial.check(settings, world)
    agent = build.agent(settings, world)
    if not agent.learns or agent.on_policy:
        why = "learns only from the episode it has just run" if agent.learns else "does not learn"
        raise ConfigError(f"agent={settings.agent.name} {why}, so stored episodes cannot train it. "
                          "Choose agent=lbs_dreamer.")
    keeping.newest_drawn(agent, settings.loop)
    length, most = getattr(settings.agent, "sequence_length", 0), episodes.longest(data, names, agent.every)
    if length > most + 1:
        shorter = ", or a shorter agent.action_repeat" if agent.every.held > 1 else ""
        raise ConfigError(f"agent.sequence_length={length} does not fit into the longest episode of {data}, "
                          f"{most} {agent.every.unit}. Set agent.sequence_length={most + 1} or less{shorter}.")


def check_server(settings: Config) -> None:
    """Check the settings of a training server. Raises UserError."""
    initial.check(settings, build.world(settings))
    if settings.data:
        raise ConfigError("data=... and storage=... are two places to learn from. Give one of them.")
    if settings.learner is Learner.remote:
        raise ConfigError("learner=remote is for the robot, curionav explore; curionav train itself learns. "
                          "Leave it out.")
    build.check(settings)
    build.check_lengths(settings)
    keeping.check(settings, lambda: build.agent(settings, build.world(settings)))
    remote_setup.check(settings)


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """Print the last lines of a training or a sweep of them, also of one that was interrupted."""
    runs = [RunFolder(folder)] if (folder / "config.yaml").is_file() else RunFolder.inside(folder)
    console = a_console()
    for run in runs:
        status = run.status
        used = status.get("replay", {})
        done = f"iteration {status.get('iteration')} of {status.get('iterations')}" if "iteration" in status else \
            f"weights {status.get('episode')}"
        console.print(f"{run.path.name}: {status.get('state')}, {done}, {used.get('episodes')} episodes, "
                      f"{used.get('steps')} steps{of_data(run)}", soft_wrap=True, highlight=False, markup=False)
        print_files(console, run.path, ("metrics.jsonl", "figures/probe.png", "checkpoint"))
    if runs:
        on = f"curionav resume {shlex.quote(str(folder))}"
        served = (runs[0].path / "ledger.sqlite").is_file()
        print_next(console, [f"{on}   (goes on serving)" if served else
                                 f"{on} loop.iterations=...   (the same training, longer)"])


def of_data(run: RunFolder) -> str:
    """Whose episodes a training learned from, ' of bounce, mapper'; nothing of a plain folder, or of a server."""
    path = run.path / "run.json"
    agents = {one["agent"]["name"]: None for one in (read_json(path) if path.is_file() else {}).get("data") or ()}
    return f" of {', '.join(agents)}" if agents else ""
