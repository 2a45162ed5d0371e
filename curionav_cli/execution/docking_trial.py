"""The docking trial: episodes of an agent that does not learn, each followed by a return to dock."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import settings_yaml
from curionav_cli.errors import RunFolderError
from curionav_cli.execution.lifecycle import fixed_settings
from curionav_cli.execution.progress import DockProgress, line
from curionav_cli.files import file_name
from curionav_cli.loop import Callbacks, NoLearning, run_episodes
from curionav_cli.records import DockReport, Episode
from curionav_cli.robot.env import RobotEnv
from curionav_cli.storage import checkpoint
from curionav_cli.storage.run_folder import RunFolder

EVERY = 10  # requests between two checkpoints


class DockingTrial:
    """Episodes, each followed by a return to dock (lifecycle.Task)."""

    unit, key = "docking request", "homecoming"

    def __init__(self, settings: Config, folder: Path):
        self.settings, self.run, self.total = settings, RunFolder(folder), settings.dock.requests
        self.world = build.scene(settings)
        self.fixed = fixed_settings(settings, self.world.plan, loop=("steps",))

    def agent(self) -> Agent:
        return build.agent(self.settings, self.world)

    def create(self, about: dict[str, Any]) -> None:
        self.run.create(settings_yaml(self.settings), self.fixed, about, self.world.plan)

    def verify(self, done: int) -> None:
        rows = self.run.metrics()
        if len(rows) < done:
            raise RunFolderError(f"{self.run.metrics_file} ends after {len(rows)} of {done} docking requests, "
                                 "so the run cannot go on. Restore it from a copy.")

    def tidy(self) -> None:
        """Nothing: a trial stores no images."""

    def rewind(self, done: int) -> None:
        self.run.write_metrics(self.run.metrics()[:done])

    def work(self, agent: Agent, first: int) -> None:
        """Run from request `first` to the last, then write tables and figure."""
        run, settings = self.run, self.settings
        env = build.robot_env(settings, self.world, pictures=agent.learns or agent.sees)
        saved = checkpoint.newest(run.checkpoints, self.fixed, self.verify)
        if saved:  # the episode before request `first` is done, and the robot stands at its end
            env.load(saved[1])
        docked = sum(row["code"] == "docked" for row in run.metrics())
        run.set_status(state="running", error=None, homecoming=first, requests=self.total)
        with closing(line(f"{settings.env.name} seed {settings.seed}", first, self.total)) as progress:
            recorder = TrialRecorder(run, agent, env, self.fixed, DockProgress(progress, docked))
            run_episodes(env, agent, recorder, episodes=self.total, steps=settings.loop.steps, seed=settings.seed,
                         watch=recorder, first=first + bool(saved), return_after_last=True)
        run.set_status(homecoming=self.total)
        draw([run], run.path)


class TrialRecorder(NoLearning, Callbacks):
    """Save a trial: a checkpoint before every tenth return to dock, a row of metrics.jsonl after each."""

    def __init__(self, run: RunFolder, agent: Agent, env: RobotEnv, fixed: dict[str, Any], report: DockProgress):
        self.run, self.agent, self.env, self.fixed, self.report = run, agent, env, fixed, report

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        if index % EVERY == 0:
            checkpoint.save(self.run.checkpoints, index, self.fixed, self.save)
            self.run.set_status(homecoming=index)
        return {}

    def save(self, folder: Path) -> None:
        """Fill a checkpoint with all that is needed to continue from the end of an episode."""
        self.agent.save(folder)
        self.env.save(folder)

    def began(self, index: int, info: dict[str, Any]) -> None:
        if info["dock"]:  # none: the run begins on the dock
            report = DockReport.of(info["dock"])
            self.run.append_metrics({"episode": index - 1, **asdict(report)})
            self.report.request_done(report.success)


def draw(runs: Sequence[RunFolder], root: Path) -> None:
    """Write the tables and the figure of arrivals of these runs into `root`."""
    from curionav_cli.results import docking, docking_plots, plots, tables  # matplotlib only when there is something

    each, together = docking.counted(runs)
    rows = [docking.summary(trial.where, trial.docks) for trial in [*each, *together]]
    ends = [row for trial in [*each, *together] for row in docking.endings(trial.where, trial.docks)]
    tries = [row for trial in [*each, *together] for row in docking.attempts(trial.where, trial.docks)]
    parts = (tables.markdown(rows, docking.TABLE, docking.BELOW),
             tables.markdown(ends, docking.FAILURES, "counts add up to the requests"),
             tables.markdown(tries, docking.RECOVERIES, "attempts by what came before them"))
    text = {"table.md": "\n".join(parts), "results.csv": tables.comma_separated(rows),
            "endings.csv": tables.comma_separated(ends), "attempts.csv": tables.comma_separated(tries)}
    folder = RunFolder(root)
    for name, content in text.items():
        folder.write(name, content)
    folder.figures.mkdir(exist_ok=True)
    pooled = [{**trial.where, "seed": None} for trial in together]
    single = [trial for trial in each if {**trial.where, "seed": None} not in pooled]
    for run, where, docks in [*together, *single]:
        light, name = run.settings["robot"]["docking"]["infrared"], ", ".join(map(str, where.values()))
        title = f"{name}\n{sum(dock.success for dock in docks)} of {len(docks)} docked"
        figure = docking_plots.arrivals(docks, light["cone"], light["range"], run.plan.radius, title)
        plots.save(figure, folder.figures / f"arrivals{'' if len(runs) == 1 else '_' + file_name(name)}.png")
