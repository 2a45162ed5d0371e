"""Looks on while a run is lived: counts coverage, writes metrics, checkpoint and status, in that order."""

from __future__ import annotations

from typing import Any

from curionav_cli.agents.agent import Agent
from curionav_cli.commands.progress import Report
from curionav_cli.records import Episode, Foresight
from curionav_cli.results.coverage import Coverage
from curionav_cli.storage import checkpoint
from curionav_cli.storage.replay import Replay
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.motion import FORWARD, LEFT, RIGHT


class Recorder:
    """The loop's watcher (loop.Watcher). `fixed`: the settings that a resumed run may not change."""

    def __init__(self, run: RunFolder, agent: Agent, replay: Replay, coverage: Coverage, fixed: dict[str, Any],
                 report: Report):
        self.run, self.agent, self.replay, self.coverage = run, agent, replay, coverage
        self.fixed, self.report = fixed, report

    def counts(self) -> dict[str, float]:
        """What the run has covered so far."""
        return {"steps": self.coverage.steps, "visited": self.coverage.visited,
                "visitable": self.coverage.total, "coverage": self.coverage.share}

    def acted(self, step: int) -> None:
        self.report.acted(step)

    def learned(self, iteration: int) -> None:
        self.report.learned(iteration)

    def foresaw(self, index: int, foresight: Foresight) -> None:
        self.run.save_foresight(index, foresight)

    def lived(self, index: int, episode: Episode, metrics: dict[str, float]) -> None:
        cells = self.coverage.add(episode.pose)
        counts = self.counts()
        self.run.append_metrics({"episode": index, **counts, "cells_in_episode": cells, **habits(episode), **metrics})
        checkpoint.save(self.run.checkpoints, index + 1, self.fixed, self.agent.save)
        self.run.set_status(episode=index + 1, **counts, **usage(self.agent, self.replay))
        self.report.lived(self.coverage.share, self.coverage.visited, self.coverage.total)


def usage(agent: Agent, replay: Replay) -> dict[str, Any]:
    """What a learner's replay holds, for status.json."""
    return {"replay": {"episodes": len(replay), "steps": replay.steps, "bytes_in_memory": replay.in_memory,
                       "bytes_on_disk": replay.on_disk}} if agent.learns else {}


def habits(episode: Episode) -> dict[str, float]:
    """Shares of the three actions among all steps, and of cut-short moves among forward moves."""
    forward = episode.action == FORWARD
    return {
        "forward": float(forward.mean()), "left": float((episode.action == LEFT).mean()),
        "right": float((episode.action == RIGHT).mean()),
        "cancelled": float(episode.collided.sum() / max(1, forward.sum())),
    }
