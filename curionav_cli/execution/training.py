"""Offline training on stored episodes."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import settings_yaml
from curionav_cli.errors import RunFolderError
from curionav_cli.execution.bag_data import folder_of
from curionav_cli.execution.exploration import drawn_figures
from curionav_cli.execution.keeping import newest_drawn
from curionav_cli.execution.lifecycle import fixed_settings, run_task
from curionav_cli.execution.peak_memory import PeakMemory
from curionav_cli.execution.precision import with_precision
from curionav_cli.execution.probing import prober
from curionav_cli.execution.progress import TrainProgress, line
from curionav_cli.execution.recorder import TrainRecorder
from curionav_cli.execution.trained import begin_from, initial
from curionav_cli.files import read_json
from curionav_cli.loop import train as learn
from curionav_cli.storage import episodes
from curionav_cli.storage.loggers import Loggers
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder

EVERY = 100  # iterations between two saves


def train(settings: Config, folder: Path) -> RunFolder:
    """Train in `folder` to the end; a training that has begun there is continued.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    return run_task("train", Training(with_precision(settings, folder), folder))


class Training:
    """Offline training on the episodes that are in `data` when it begins, not on later ones (lifecycle.Task)."""

    unit = key = "iteration"

    def __init__(self, settings: Config, folder: Path):
        self.memory = PeakMemory()
        self.settings, self.run, self.total = settings, RunFolder(folder), settings.loop.iterations
        self.data, self.world = folder_of(settings), build.world(settings)
        begun = read_json(folder / "fixed.json") if self.run.config.is_file() else {}
        names = list(begun.get("episodes", ())) or episodes.names(self.data)
        self.fixed = fixed_settings(settings, self.world.plan)
        self.fixed["episodes"] = episodes.checksums(self.data, names)
        self.fixed |= initial(settings, self.run)

    def agent(self) -> Agent:
        agent = build.agent(self.settings, self.world)
        begin_from(agent, self.settings, self.run)
        return agent

    def create(self, about: dict[str, Any]) -> None:
        about = {**about, "data": episodes.collected_by(self.data), "environments": episodes.environments(self.data)}
        self.run.create(settings_yaml(self.settings), self.fixed, about, plan=None)

    def verify(self, done: int) -> None:
        if not any(row["iterations"] == done for row in self.run.metrics()):
            raise RunFolderError(f"{self.run.metrics_file} does not reach iteration {done}, so the run cannot go on. "
                                 "Restore it from a copy.")

    def tidy(self) -> None:
        """Nothing: a training stores no images."""

    def rewind(self, done: int) -> None:
        self.run.write_metrics([row for row in self.run.metrics() if row["iterations"] <= done])

    def work(self, agent: Agent, first: int) -> None:
        """Train from iteration `first` to the last, then draw the figures."""
        with closing(Loggers(self.run, self.settings.loggers)) as logger:
            self.train(agent, first, logger)
            logger.add_figures(drawn_figures(self.run))

    def train(self, agent: Agent, first: int, logger: Loggers) -> None:
        """Train from iteration `first` to the last."""
        run, settings = self.run, self.settings
        label = f"{settings.agent.name} seed {settings.seed} on {Path(settings.data or '').name}"
        stored, loop = [self.data / name for name in self.fixed["episodes"]], settings.loop
        with closing(Replay.open(stored, memory=loop.replay_memory * 1e9, folder=run.path, every=agent.every,
                                 newest=newest_drawn(agent, loop))) as replay, \
                closing(line(label, first, self.total)) as progress:
            probes = prober(settings, self.fixed, self.world, agent, run.path, EVERY)
            recorder = TrainRecorder(run, agent, replay, self.fixed, logger, probes, self.memory,
                                     TrainProgress(progress))
            run.set_status(state="running", error=None, iteration=first, iterations=self.total, **recorder.usage())
            learn(agent, replay, iterations=self.total, every=EVERY, watch=recorder, first=first)
        if probes.probe:
            from curionav_cli.results.probing import figures  # matplotlib is loaded once there is something to draw

            figures.draw(run.path, run.figures)
