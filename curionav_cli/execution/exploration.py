"""Explore: an agent acts in an environment and learns between episodes; its run folder holds the results."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config, Learner
from curionav_cli.config.settings import read_settings, settings_yaml
from curionav_cli.execution import remote_setup
from curionav_cli.execution.keeping import Keeping, newest_drawn, refuse_gone, refuse_with_storage
from curionav_cli.execution.lifecycle import fixed_settings, run_task
from curionav_cli.execution.peak_memory import PeakMemory
from curionav_cli.execution.precision import with_precision
from curionav_cli.execution.probing import prober
from curionav_cli.execution.progress import ExploreProgress, line
from curionav_cli.execution.recorder import Recorder
from curionav_cli.execution.trained import begin_from, initial
from curionav_cli.files import refuse_broken
from curionav_cli.loop import LocalLearner, run_episodes
from curionav_cli.records import FloorPlan
from curionav_cli.results.coverage import cover
from curionav_cli.storage import checkpoint
from curionav_cli.storage.loggers import Loggers
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder


def explore(settings: Config, folder: Path, drawn: bool = True) -> RunFolder:
    """Run an exploration in `folder` to its end; one that has begun there is continued. drawn: with figures.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    return run_task("explore", Exploration(with_precision(settings, folder), folder, drawn))


class Exploration:
    """Episodes of acting, each followed by learning (lifecycle.Task)."""

    unit = key = "episode"

    def __init__(self, settings: Config, folder: Path, drawn: bool = True):
        refuse_with_storage(settings)
        self.memory = PeakMemory()
        self.settings, self.run, self.total = settings, RunFolder(folder), settings.loop.episodes
        self.drawn = drawn
        self.world = build.world(settings)
        self.fixed = fixed_settings(settings, self.world.plan, loop=("steps", "iterations"))
        self.shared = {key: value for key, value in self.fixed.items() if key != "robot"}  # with a server
        self.shared["agent"] = {key: value for key, value in self.fixed["agent"].items() if key != "precision"}
        self.remote = settings.learner is Learner.remote
        if self.remote:
            self.fixed["learner"] = "remote"
        self.fixed |= self.initial()

    def initial(self) -> dict[str, Any]:
        """The weights that the run begins with, for fixed.json."""
        return initial(self.settings, self.run)

    def agent(self) -> Agent:
        agent = build.agent(self.settings, self.world)
        begin_from(agent, self.settings, self.run)
        return agent

    def env(self, first: int) -> build.Environment:
        """Build the environment, in the state that it has before episode `first`."""
        env = build.env(self.settings, self.world)
        if first:
            env.load(checkpoint.at(self.run.checkpoints, first))
        return env

    def create(self, about: dict[str, Any]) -> None:
        about = {**about, "engine": self.settings.env.engine.value}
        self.run.create(settings_yaml(self.settings), self.fixed, about, self.world.plan)

    def verify(self, done: int) -> None:
        self.run.refuse_gaps(done)
        FloorPlan.load(self.run.path / "plan.npz")  # a broken one is found before anything is run
        paths = self.run.episode_paths()[:done]
        for path in paths:
            refuse_broken(path)
        if done < self.total:
            refuse_gone(paths[-(self.settings.loop.replay_episodes or 0):], self.settings.loop, self.agent)

    def rewind(self, done: int) -> None:
        self.run.rewind(done)

    def work(self, agent: Agent, first: int) -> None:
        """Run from episode `first` to the last, then draw the figures."""
        with closing(Loggers(self.run, self.settings.loggers)) as logger:
            self.explore(agent, first, logger)
            if self.drawn:
                draw(self.run)
            logger.add_figures(drawn_figures(self.run))
            self.keeping(agent).finish()
        if self.remote:
            remote_setup.refuse_undelivered(self.run)

    def keeping(self, agent: Agent) -> Keeping:
        """What of the run's images is kept."""
        loop = self.settings.loop
        return Keeping(self.run, loop.keep, agent.every, newest_drawn(agent, loop))

    def replay(self, agent: Agent, more: bool) -> Replay:
        """The stored episodes that the learner may draw, if `more` follow.

        A replay of a single episode begins empty, as the next one takes its place.
        """
        loop, newest = self.settings.loop, newest_drawn(agent, self.settings.loop)
        stored = self.run.episode_paths() if agent.learns and not self.remote and more else []
        replaced = len(stored) if newest == 1 else 0
        replay = Replay.open(stored[replaced:], memory=loop.replay_memory * 1e9, folder=self.run.path,
                             every=agent.every, newest=newest)
        if replaced:
            replay.pass_over(replaced)
        return replay

    def tidy(self) -> None:
        """Remove the images of a run that is done, where loop.keep keeps fewer than it did."""
        if read_settings(self.run.config).loop.keep is not self.settings.loop.keep:
            kept = self.keeping(self.agent())
            kept.catch_up(len(self.run.episode_paths()))
            kept.finish()
            self.run.write("config.yaml", settings_yaml(self.settings))  # last: a kill before it leaves it to be done

    def explore(self, agent: Agent, first: int, logger: Loggers) -> None:
        """Run from episode `first` to the last."""
        run, loop, label = self.run, self.settings.loop, f"{self.settings.agent.name} seed {self.settings.seed}"
        coverage = cover(run.plan, run.poses())
        more, kept = first < loop.episodes, self.keeping(agent)
        kept.catch_up(first)
        with closing(self.replay(agent, more)) as replay, \
                closing(line(label, first, loop.episodes)) as progress, closing(self.env(first)) as env:
            recorder = Recorder(run, env, agent, None if self.remote else replay, self.fixed, logger,
                                prober(self.settings, self.fixed, self.world, agent, run.path),
                                self.memory, coverage, ExploreProgress(progress, loop), kept)
            learn = remote_setup.remote_learner(self.settings, run, agent, self.shared) if self.remote else \
                LocalLearner(agent, replay, loop.iterations, recorder, run.save_episode)
            run.set_status(state="running", error=None, episode=first, episodes=loop.episodes, **recorder.counts(),
                           **(recorder.usage() if more else {}))
            run_episodes(env, agent, learn, episodes=loop.episodes, steps=loop.steps, seed=self.settings.seed,
                         watch=recorder, first=first)


def drawn_figures(run: RunFolder) -> list[Path]:
    """The figures of a run, PNG files, sorted."""
    return sorted(run.figures.glob("*.png"))


def draw(run: RunFolder) -> None:
    """Draw the run's figures and write its table."""
    from curionav_cli.results import beliefs, plots, tables
    from curionav_cli.results.prediction import (
        figures as prediction_figures,  # matplotlib is loaded once there is something to draw
    )
    from curionav_cli.results.runs import Run

    result = Run(run)
    share = plots.share_of(result, result.denominator)
    plots.save(plots.heatmap(result.coverage, f"{result.label}\n{share}"), run.figures / "heatmap.png")
    plots.save(plots.curves([result], result.label), run.figures / "coverage.png")
    prediction_figures.draw(result, run.figures)
    if any("probe" in row for row in run.metrics()):
        from curionav_cli.results.probing import figures as probe_figures  # it loads scipy.stats

        probe_figures.draw(run.path, run.figures, (result.env, result.agent))
    if paths := beliefs.paths(result):
        plots.save(paths, run.figures / "beliefs.png")
    row = {**result.row(), "state": "done"}
    run.write("table.md", tables.markdown([row]))
    run.write("results.csv", tables.comma_separated([row]))
