"""curionav explore: an agent lives in a world; its run folder holds all that came of it."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.commands import remote
from curionav_cli.commands.launch import Request, launch
from curionav_cli.commands.lifecycle import fixed_settings, see_through
from curionav_cli.commands.precision import settled
from curionav_cli.commands.progress import Living, line
from curionav_cli.commands.recorder import Recorder
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config, Learner
from curionav_cli.config.settings import settings_yaml
from curionav_cli.errors import ConfigError
from curionav_cli.files import refuse_broken
from curionav_cli.loop import LearnHere, live
from curionav_cli.records import FloorPlan
from curionav_cli.results.coverage import cover
from curionav_cli.storage import checkpoint
from curionav_cli.storage.loggers import LOGGERS
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder


def run(request: Request) -> int:
    """The command: its exit code."""
    return launch(request, work, summary, check, "coverage")


def explore(settings: Config, folder: Path, drawn: bool = True) -> RunFolder:
    """Live the run in `folder` to its end; a folder that holds its beginning is continued. drawn: with figures.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    return see_through("explore", Exploration(settled(settings, folder), folder, drawn))


class Exploration:
    """A life (lifecycle.Undertaking)."""

    unit = "episode"

    def __init__(self, settings: Config, folder: Path, drawn: bool = True):
        self.settings, self.run, self.total = settings, RunFolder(folder), settings.loop.episodes
        self.drawn = drawn
        self.world = build.scene(settings)
        self.fixed = fixed_settings(settings, self.world.plan, loop=("steps", "iterations"))
        self.shared = {key: value for key, value in self.fixed.items() if key != "robot"}  # with a server
        self.shared["agent"] = {key: value for key, value in self.fixed["agent"].items() if key != "precision"}
        self.remote = settings.learner is Learner.remote
        if self.remote:
            self.fixed["learner"] = "remote"

    def agent(self) -> Agent:
        return build.agent(self.settings, self.world)

    def env(self, first: int) -> build.World:
        """The world as episode `first` finds it."""
        env = build.env(self.settings, self.world)
        if first:
            env.load(checkpoint.at(self.run.checkpoints, first))
        return env

    def create(self, about: dict[str, Any]) -> None:
        about = {**about, "engine": self.settings.env.engine.value}
        self.run.create(settings_yaml(self.settings), self.fixed, about, self.world.plan)

    def built_on(self, done: int) -> None:
        self.run.refuse_gaps(done)
        FloorPlan.load(self.run.path / "plan.npz")  # found broken before anything is lived
        for path in self.run.episode_paths()[:done]:
            refuse_broken(path)

    def rewind(self, done: int) -> None:
        self.run.rewind(done)

    def work(self, agent: Agent, first: int) -> None:
        """From episode `first` to the last, then the figures."""
        run, loop, label = self.run, self.settings.loop, f"{self.settings.agent.name} seed {self.settings.seed}"
        coverage = cover(run.plan, run.poses())
        stored = run.episode_paths() if agent.learns and not self.remote else []
        memory = loop.replay_memory * 1e9
        with closing(Replay.open(stored, memory=memory, folder=run.path, every=agent.every)) as replay, \
                closing(LOGGERS[self.settings.logger.value](run)) as logger, \
                closing(line(label, first, loop.episodes)) as shown:
            env = self.env(first)
            recorder = Recorder(run, env, agent, None if self.remote else replay, self.fixed, logger,
                                coverage, Living(shown, loop))
            learn = remote.there(self.settings, run, agent, self.shared) if self.remote else \
                LearnHere(agent, replay, loop.iterations, recorder, run.save_episode)
            run.set_status(state="running", error=None, episode=first, episodes=loop.episodes, **recorder.counts(),
                           **recorder.usage())
            live(env, agent, learn, episodes=loop.episodes, steps=loop.steps, seed=self.settings.seed, watch=recorder,
                 first=first)
        if self.drawn:
            draw(run)
        if self.remote:
            remote.refuse_undelivered(run)


def draw(run: RunFolder) -> None:
    """The run's figures and table."""
    from curionav_cli.commands import predictions  # matplotlib is loaded once there is something to draw
    from curionav_cli.results import beliefs, plots, tables
    from curionav_cli.results.runs import Run

    result = Run(run)
    share = f"{tables.percent(result.coverage.share)} of {result.coverage.total:,} {result.denominator} cells"
    plots.save(plots.heatmap(result.coverage, f"{result.label}\n{share}"), run.figures / "heatmap.png")
    plots.save(plots.curves([result], result.label), run.figures / "coverage.png")
    predictions.draw(result, run.figures)
    if paths := beliefs.paths(result):
        plots.save(paths, run.figures / "beliefs.png")
    row = {**result.row(), "state": "done"}
    run.write("table.md", tables.markdown([row]))
    run.write("results.csv", tables.comma_separated([row]))


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
        remote.check(settings)
    elif settings.storage:
        raise ConfigError("storage=... is where another process learns: add learner=remote.")


def summary(folder: Path, outcomes: list[Outcome]) -> None:
    """The last lines of a run or a sweep, also of one that was interrupted."""
    from curionav_cli.commands.summary import show  # matplotlib is loaded once there is something to draw

    show(folder, [outcome.folder for outcome in outcomes])
