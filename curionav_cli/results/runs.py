"""A finished or running run, as results read it: settings, episodes, coverage, cost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.constants import FORWARD
from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_arrays
from curionav_cli.records import FloorPlan
from curionav_cli.results.coverage import Coverage, Curve
from curionav_cli.results.integrity import Readable, readable
from curionav_cli.results.labels import flat, labels, scene_name, world_labels, world_settings
from curionav_cli.storage.run_folder import RunFolder

ACTION_NAMES = ("forward", "left", "right")
SECONDS = {  # what a run cost: the metrics of each episode that add up to it
    "seconds": ("seconds_acting", "seconds_learning"), "cpu_seconds": ("cpu_seconds_acting", "cpu_seconds_learning"),
}
COUNTED = {"updates": "updates", "frames_read": "frames_replayed"}  # and those that the agent counts from the beginning
MEMORY = "peak_memory"  # bytes; of a run that was resumed, of each process up to there


@dataclass
class Run:
    """Read lazily from a run folder; nothing is kept that the folder does not hold."""

    folder: RunFolder
    rule: str = "landing"
    denominator: str = "visitable"
    variant: str = ""
    world: str = ""

    @classmethod
    def open(cls, path: Path) -> Run:
        """Raises RunFolderError where `path` is no run."""
        return cls(RunFolder.existing(path))

    @cached_property
    def config(self) -> dict[str, Any]:
        return self.folder.settings

    @property
    def env(self) -> str:
        """The scene's or map's name; with the settings that distinguish it, once `distinguish` has run."""
        return self.world or scene_name(self.config["env"])

    @property
    def state(self) -> str:
        """One of running, done, failed, interrupted; unknown where status.json is broken."""
        try:
            return self.folder.state
        except RunFolderError:
            return "unknown"

    @property
    def agent(self) -> str:
        """The agent's name, with the settings that distinguish it, once `distinguish` has run."""
        return self.config["agent"]["name"] + self.variant

    @property
    def seed(self) -> int:
        return self.config["seed"]

    @property
    def preset(self) -> str:
        """The scale (cpu, paper) that its settings came from."""
        return self.config["scale"]

    @property
    def label(self) -> str:
        return f"{self.env}, {self.agent}, seed {self.seed}"

    @property
    def by_estimate(self) -> bool:
        """Whether its poses are estimated: those of a real robot are, as nothing measures the true ones."""
        return "floor" in self.config["env"]

    @cached_property
    def plan(self) -> FloorPlan:
        return self.folder.plan

    @cached_property
    def readable(self) -> Readable:
        """The part that can be shown. Raises RunFolderError where the run has no plan: then nothing can."""
        return readable(self.folder, self.plan, self.rule, self.denominator)

    @property
    def coverage(self) -> Coverage:
        """Coverage of the episodes up to the first that is missing or broken."""
        return self.readable.coverage

    @property
    def episodes(self) -> list[Path]:
        """Files of the episodes up to the first that is missing or broken."""
        return [self.folder.episode_path(index) for index in range(len(self.readable.ends) - 1)]

    @property
    def predictions(self) -> dict[int, Path]:
        """Files of the agent's predictions of these episodes, by episode; none where it predicts nothing."""
        readable = len(self.readable.ends) - 1
        return {index: path for index, path in self.folder.prediction_paths().items() if index < readable}

    def poses(self) -> list[np.ndarray]:
        """Read the poses (T+1, 3) of each of these episodes, metres and radians."""
        return [read_arrays(path, ("pose",))["pose"] for path in self.episodes]

    @cached_property
    def curve(self) -> Curve:
        return self.coverage.curve()

    def row(self) -> dict[str, Any]:
        """Make a row of a table; shares between 0 and 1, missing numbers as None."""
        metrics = self.folder.metrics()
        status = self.readable.status
        mix, cut = self.action_mix()
        steps = max(1, mix.total())
        return {
            "env": self.env, "agent": self.agent, "seed": self.seed, "state": self.state,
            "episodes": len(metrics), "steps": self.coverage.steps, "marking": self.rule,
            "denominator": self.denominator, "visited": self.coverage.visited, "cells": self.coverage.total,
            "coverage": self.coverage.share, "area_under_curve": self.curve.area(),
            **{f"steps_to_{share:.0%}".replace("%", ""): self.curve.steps_to(share) for share in (0.5, 0.8, 0.9, 0.99)},
            "steps_to_explored": status.get("explored_at"),
            **{name: mix[index] / steps for index, name in enumerate(ACTION_NAMES)},
            "cancelled": cut / mix[FORWARD] if mix[FORWARD] else None, **dock_returns(metrics), **probed(metrics),
            **{key: known(sums[-1]) for key, sums in spent(metrics).items()},
            "seconds_acting": sum(row["seconds_acting"] for row in metrics),
            "seconds_learning": sum(row["seconds_learning"] for row in metrics),
            **({"pose": "estimated"} if self.by_estimate else {}),
            "error": status.get("error"), "folder": str(self.folder.path),
        }

    def action_mix(self) -> tuple[Counter[int], int]:
        """Count each action, and the forward moves that were cut short or cancelled."""
        mix, cut = Counter[int](), 0
        for path in self.episodes:
            acted = read_arrays(path, ("action", "collided"))
            mix.update(acted["action"].tolist())
            cut += int(acted["collided"].sum())
        return mix, cut


def dock_returns(metrics: list[dict[str, Any]]) -> dict[str, int]:
    """Count how often the robot docked and how often a person carried it; {} where it has no dock."""
    rows = [row for row in metrics if "docked" in row]
    return {name: sum(row[name] for row in rows) for name in ("docked", "carried") if rows}


def probed(metrics: list[dict[str, Any]]) -> dict[str, float]:
    """The newest error and surprise on the building's probe; {} where the world model was never measured."""
    rows = [row for row in metrics if "probe_error" in row]
    return {key: rows[-1][key] for key in ("probe_error", "probe_surprise") if rows}


def distinguish(runs: Sequence[Run]) -> None:
    """Add to names of agents and scenes what distinguishes runs: 'cbet view=ego', 'small_room camera=0.9'."""
    agents = [run.config["agent"] for run in runs]
    names = [agent["name"] for agent in agents]
    for run, name, label in zip(runs, names, labels(names, list(map(flat, agents)), [run.preset for run in runs])):
        run.variant = label.removeprefix(name)
    envs = [run.config["env"] for run in runs]
    for run, label in zip(runs, world_labels(envs, [world_settings({"env": env}) for env in envs])):
        run.world = label


def job_number(name: str) -> tuple[int, str]:
    """Sort key by which 2_small_room_random_0 comes before 10_small_room_random_8."""
    number = name.split("_")[0]
    return (int(number) if number.isdecimal() else -1, name)


def spent(metrics: list[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Sum every part of the budget after 0 to E episodes, (E + 1,); nan from where it was not noted.

    memory is no sum, but the most so far of what was noted, GB.
    """
    each = {key: [[row.get(part, np.nan) for part in parts] for row in metrics] for key, parts in SECONDS.items()}
    return {**{key: np.cumsum([0.0, *(sum(parts) for parts in rows)]) for key, rows in each.items()},
            **{key: np.array([0.0, *(row.get(part, np.nan) for row in metrics)]) for key, part in COUNTED.items()},
            "memory": np.fmax.accumulate([np.nan, *(row.get(MEMORY, np.nan) / 1e9 for row in metrics)])}


def known(number: float) -> float | None:
    return None if np.isnan(number) else float(number)
