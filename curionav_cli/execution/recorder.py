"""Record a run as it goes on: metrics, checkpoint and status, written in that order."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.constants import FORWARD, LEFT, RIGHT
from curionav_cli.execution.keeping import Keeping
from curionav_cli.execution.peak_memory import PeakMemory
from curionav_cli.execution.probing import Prober
from curionav_cli.execution.progress import ExploreProgress, ServeProgress, TrainProgress, say
from curionav_cli.geometry import wrapped
from curionav_cli.loop import Callbacks
from curionav_cli.records import Episode, Prediction
from curionav_cli.results.coverage import Coverage
from curionav_cli.storage import checkpoint
from curionav_cli.storage.loggers import Local
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder


class Keeper:
    """Save a run's progress, so that a killed run can be resumed. fixed: the settings that may then not change."""

    def __init__(self, run: RunFolder, agent: Agent, replay: Replay | None, fixed: dict[str, Any], logger: Local,
                 prober: Prober, memory: PeakMemory):
        self.run, self.agent, self.replay, self.fixed, self.logger = run, agent, replay, fixed, logger
        self.prober, self.memory = prober, memory

    def keep(self, done: int, row: dict[str, Any], **status: Any) -> None:
        """Save after `done` episodes or iterations: a row of metrics.jsonl, a checkpoint, the status."""
        row = {**row, **self.prober.metrics(done), "peak_memory": self.memory.bytes()}
        self.run.append_metrics(row)
        self.logger.add(row)
        checkpoint.save(self.run.checkpoints, done, self.fixed, self.save)
        self.run.set_status(**status, **self.usage())

    def save(self, folder: Path) -> None:
        """Fill a checkpoint with the agent."""
        self.agent.save(folder)

    def usage(self) -> dict[str, Any]:
        """The size of the replay, for status.json; {} without a learner in this process."""
        replay = self.replay
        if replay is None or not self.agent.learns:
            return {}
        return {"replay": {"episodes": len(replay) - replay.dropped, "steps": replay.steps,
                           "bytes_in_memory": replay.in_memory, "bytes_on_disk": replay.on_disk}}


class Recorder(Keeper, Callbacks):
    """Record a run (loop.Callbacks) and count its coverage. env: None where the robot acts elsewhere."""

    def __init__(self, run: RunFolder, env: build.Environment | None, agent: Agent, replay: Replay | None,
                 fixed: dict[str, Any], logger: Local, prober: Prober, memory: PeakMemory, coverage: Coverage,
                 report: ExploreProgress | ServeProgress, keeping: Keeping):
        super().__init__(run, agent, replay, fixed, logger, prober, memory)
        self.env, self.coverage, self.report, self.keeping = env, coverage, report, keeping

    def save(self, folder: Path) -> None:
        """Fill a checkpoint with the agent and the state of the environment after this episode."""
        super().save(folder)
        if self.env:
            self.env.save(folder)

    def counts(self) -> dict[str, float | None]:
        """Steps and coverage of the run so far."""
        return {"steps": self.coverage.steps, "visited": self.coverage.visited,
                "visitable": self.coverage.total, "coverage": self.coverage.share}

    def acted(self, step: int) -> None:
        self.report.acted(step)

    def learned(self, iteration: int) -> None:
        self.report.learned(iteration)

    def predicted(self, index: int, prediction: Prediction) -> None:
        self.run.save_prediction(index, prediction)

    def episode_done(self, index: int, episode: Episode, metrics: dict[str, float]) -> None:
        cells = self.coverage.add(episode.pose)
        counts = self.counts()
        row = {"episode": index, **counts, "cells_in_episode": cells, "found": self.coverage.first[-1].tolist(),
               **action_shares(episode), **estimate_error(episode), **metrics}
        explored = {"explored": True, "explored_at": int(metrics["explored"])} if "explored" in metrics else {}
        self.keep(index + 1, row, episode=index + 1, **counts, **explored)
        self.keeping.after(index + 1)
        for event in episode.events:
            if event["what"] == "closed":
                say(f"episode {index} was closed after {len(episode)} steps: {event['why']}")
        self.report.episode_done(self.coverage.steps, self.coverage.share, self.coverage.visited, self.coverage.total)


class TrainRecorder(Keeper):
    """Record offline training (loop.TrainCallbacks)."""

    def __init__(self, run: RunFolder, agent: Agent, replay: Replay, fixed: dict[str, Any], logger: Local,
                 prober: Prober, memory: PeakMemory, report: TrainProgress):
        super().__init__(run, agent, replay, fixed, logger, prober, memory)
        self.report = report

    def learned(self, iteration: int) -> None:
        self.report.learned(iteration)

    def trained(self, iterations: int, metrics: dict[str, float]) -> None:
        self.keep(iterations, {"iterations": iterations, **metrics}, iteration=iterations)
        self.report.trained(iterations)


def estimate_error(episode: Episode) -> dict[str, Any]:
    """The error of the pose estimate at the end of an episode (m, degrees), and how the robot had returned to its dock.

    {} for an episode without an estimate, of a robot with perfect motion. No error of a real robot, whose true pose
    nothing measures.
    """
    if episode.estimate is None:
        return {}
    x, y, yaw = episode.estimate[-1] - episode.pose[-1]
    returned = {"docked": not episode.dock["human"], "carried": episode.dock["human"]} if episode.dock else {}
    if (episode.estimate == episode.pose).all():
        return returned
    return {"position_error": math.hypot(x, y), "yaw_error": math.degrees(abs(wrapped(yaw))), **returned}


def action_shares(episode: Episode) -> dict[str, float]:
    """Shares of the three actions among all steps, and of cancelled moves among forward moves."""
    forward = episode.action == FORWARD
    return {
        "forward": float(forward.mean()), "left": float((episode.action == LEFT).mean()),
        "right": float((episode.action == RIGHT).mean()),
        "cancelled": float(episode.collided.sum() / max(1, forward.sum())),
    }
