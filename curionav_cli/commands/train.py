"""curionav train: an agent learns from stored episodes, without living; its run folder is that of a life without one.

loop.iterations are all iterations together. A save follows every hundredth, the K of the paper, as one
follows every episode of a life.
"""

from __future__ import annotations

import shlex
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.commands import remote
from curionav_cli.commands import summary as end
from curionav_cli.commands.launch import Request, launch
from curionav_cli.commands.lifecycle import fixed_settings, see_through
from curionav_cli.commands.precision import settled
from curionav_cli.commands.progress import Studying, line
from curionav_cli.commands.recorder import Study
from curionav_cli.commands.screen import a_console
from curionav_cli.commands.serve import serve
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config, Learner
from curionav_cli.config.settings import settings_yaml
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.files import read_json
from curionav_cli.loop import train as learn
from curionav_cli.storage import episodes
from curionav_cli.storage.loggers import LOGGERS
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder

EVERY = 100  # iterations between two saves


def run(request: Request) -> int:
    """The command: its exit code. --follow is the one setting that has a word of its own."""
    words = ["remote.follow=true" if word == "--follow" else word for word in request.overrides]
    return launch(replace(request, overrides=words), work, summary, check)


def train(settings: Config, folder: Path) -> RunFolder:
    """Train in `folder` to the end; a folder that holds the beginning is continued.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    return see_through("train", Training(settled(settings, folder), folder))


class Training:
    """Learning from what stands in `data` when it begins (lifecycle.Undertaking); episodes that come later do not."""

    unit = "iteration"

    def __init__(self, settings: Config, folder: Path):
        self.settings, self.run, self.total = settings, RunFolder(folder), settings.loop.iterations
        self.data, self.world = Path(settings.data or ""), build.scene(settings)
        begun = read_json(folder / "fixed.json") if self.run.config.is_file() else {}
        names = list(begun.get("episodes", ())) or episodes.names(self.data)
        self.fixed = fixed_settings(settings, self.world.plan)
        self.fixed["episodes"] = episodes.checksums(self.data, names)

    def agent(self) -> Agent:
        return build.agent(self.settings, self.world)

    def create(self, about: dict[str, Any]) -> None:
        self.run.create(settings_yaml(self.settings), self.fixed, about, plan=None)

    def built_on(self, done: int) -> None:
        if not any(row["iterations"] == done for row in self.run.metrics()):
            raise RunFolderError(f"{self.run.metrics_file} does not reach iteration {done}, so the run cannot go on. "
                                 "Restore it from a copy.")

    def rewind(self, done: int) -> None:
        self.run.write_metrics([row for row in self.run.metrics() if row["iterations"] <= done])

    def work(self, agent: Agent, first: int) -> None:
        """From iteration `first` to the last."""
        run, label = self.run, f"{self.settings.agent.name} seed {self.settings.seed}"
        stored, memory = [self.data / name for name in self.fixed["episodes"]], self.settings.loop.replay_memory * 1e9
        with closing(Replay.open(stored, memory=memory, folder=run.path, every=agent.every)) as replay, \
                closing(LOGGERS[self.settings.logger.value](run)) as logger, \
                closing(line(label, first, self.total)) as shown:
            study = Study(run, agent, replay, self.fixed, logger, Studying(shown))
            run.set_status(state="running", error=None, iteration=first, iterations=self.total, **study.usage())
            learn(agent, replay, iterations=self.total, every=EVERY, watch=study, first=first)


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
    remote.check(settings)


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
