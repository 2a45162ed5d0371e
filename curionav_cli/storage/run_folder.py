"""A run on disk. Everything that results draw is read from here; a save is finished or absent.

    config.yaml      every setting, resolved; with it the run can be repeated
    fixed.json       the settings that may not change when the run goes on
    run.json         command, versions, device, engine, git commit
    status.json      state (running, done, failed, interrupted), episode, steps, coverage, error
    plan.npz         the floor plan: cells, start, obstacles
    metrics.jsonl    one object an episode; where nobody lived, one a save
    episodes/        000000.npz ...
    predictions/     000000.npz ... what the agent expected of an episode before it learned from it
    checkpoint/      the state of the agent after the last two episodes
    figures/         heatmap.png, coverage.png, predictions.png, prediction_error.png
    table.md  results.csv
"""

from __future__ import annotations

import fcntl
import json
import os
import platform
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
import yaml

from curionav_cli.errors import RunFolderError, SoundnessWarning
from curionav_cli.files import read_arrays, read_json, sealed, write_whole
from curionav_cli.records import Episode, FloorPlan, Foresight
from curionav_cli.safe_yaml import LOADER


class RunFolder:
    """Paths, and reading and writing what is at them."""

    def __init__(self, path: Path):
        self.path = Path(path)
        self.config = self.path / "config.yaml"
        self.checkpoints = self.path / "checkpoint"
        self.figures = self.path / "figures"
        self.metrics_file = self.path / "metrics.jsonl"

    @classmethod
    def existing(cls, path: Path) -> RunFolder:
        """The run at `path`. Raises RunFolderError where there is none."""
        run = cls(path)
        if not run.path.is_dir():
            raise RunFolderError(nowhere(path))
        if not run.config.is_file():
            raise RunFolderError(f"{path} holds no run: it has no config.yaml. Give the folder of one run, "
                                 "such as outputs/DATE/TIME_small_room_random_0.")
        return run

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keep every other process out. Raises RunFolderError where one is in already."""
        self.path.mkdir(parents=True, exist_ok=True)
        with open(self.path / ".lock", "a+") as lock:
            if not locked(lock, patience=0.5):
                raise self.taken()
            lock.truncate(0)
            lock.write(f"process {os.getpid()} on {platform.node()}")
            lock.flush()
            yield

    def refuse_company(self) -> None:
        """Raises RunFolderError where a process is in it now."""
        if self.alive:
            raise self.taken()

    def taken(self) -> RunFolderError:
        who = (self.path / ".lock").read_text().strip() or "another process"
        return RunFolderError(f"{self.path} is lived by {who}. Wait for it, or stop it.")

    @property
    def alive(self) -> bool:
        """Whether a process is in it now."""
        try:
            with open(self.path / ".lock") as lock:
                return not locked(lock)
        except FileNotFoundError:
            return False

    @classmethod
    def found(cls, path: Path) -> list[RunFolder]:
        """The run at `path`, or the runs of the sweep at `path`. Raises RunFolderError where there is none."""
        return cls.inside(path) or [cls.existing(path)]

    @classmethod
    def inside(cls, path: Path) -> list[RunFolder]:
        """The runs of the sweep at `path`; none where there is no sweep."""
        return [cls(file.parent) for file in sorted(path.glob("*/run.json"))
                if (file.parent / "config.yaml").is_file()]

    def refuse_rest(self) -> None:
        """Raises RunFolderError where a run was lived here, but for its config.yaml: nothing is written over it."""
        rest = sorted(path for name in ("episodes/*.npz", "checkpoint/*/done", "metrics.jsonl")
                      for path in self.path.glob(name))
        if rest and not self.config.is_file():
            raise RunFolderError(f"{self.path} holds {rest[0].relative_to(self.path)} of a run, but no config.yaml. "
                                 "Restore that from a copy, or name another folder.")

    def create(self, config: str, fixed: dict[str, Any], about: dict[str, Any], plan: FloorPlan | None) -> None:
        """Begin the run; no plan: nobody lives in it. config.yaml comes last: a folder that has it has the rest."""
        self.checkpoints.mkdir(parents=True, exist_ok=True)
        if plan:
            (self.path / "episodes").mkdir(exist_ok=True)
            self.figures.mkdir(exist_ok=True)
            plan.save(self.path / "plan.npz")
        self.write("fixed.json", json.dumps(fixed))
        self.write("run.json", json.dumps(about, indent=2))
        self.write("config.yaml", config)

    def write(self, name: str, text: str) -> None:
        """A whole text file in the run's folder."""
        write_whole(self.path / name, lambda file: file.write(text.encode()))

    @property
    def settings(self) -> dict[str, Any]:
        """env, agent, robot, seed and scale as config.yaml has them. Raises RunFolderError where it does not."""
        try:
            config = yaml.load(self.config.read_text(), LOADER) or {}
            return {"scale": config.get("scale", "")} | {key: config[key] for key in ("env", "agent", "robot", "seed")}
        except (OSError, yaml.YAMLError, TypeError, KeyError, AttributeError) as error:
            raise RunFolderError(f"{self.config} does not hold the settings of a run ({error}).") from error

    # -- status -----------------------------------------------------------------------------------

    @property
    def status(self) -> dict[str, Any]:
        """status.json; {} before the run has written one. Raises RunFolderError where it is broken."""
        path = self.path / "status.json"
        return read_json(path) if path.exists() else {}

    def set_status(self, **changes: Any) -> None:
        """A broken one is begun anew: all that stands in it is counted again by who goes on with the run."""
        try:
            before = self.status
        except RunFolderError as error:
            warnings.warn(f"{error} It is written anew.", SoundnessWarning, stacklevel=2)
            before = {}
        self.write("status.json", sealed({**before, **changes}))

    @property
    def state(self) -> str:
        """running, done, failed or interrupted; what was killed could not say so, and is interrupted too."""
        state = str(self.status.get("state", "interrupted"))
        return "interrupted" if state == "running" and not self.alive else state

    @property
    def plan(self) -> FloorPlan:
        """Raises RunFolderError where it is missing or broken."""
        there = (self.path / "plan.npz").exists()
        if not there and self.episode_names():
            raise RunFolderError(f"{self.path / 'plan.npz'} is missing. Restore it from a copy.")
        if self.config.is_file() and not there:
            raise RunFolderError(f"{self.path} has no plan.npz: nobody lived in it. A trained run has no coverage.")
        return FloorPlan.load(self.path / "plan.npz")

    # -- episodes and metrics ---------------------------------------------------------------------

    def episode_path(self, index: int) -> Path:
        return self.path / "episodes" / f"{index:06d}.npz"

    def episode_paths(self) -> list[Path]:
        """The episodes in order, up to the first that is missing."""
        paths: list[Path] = []
        while (path := self.episode_path(len(paths))).exists():
            paths.append(path)
        return paths

    def episode_names(self) -> list[str]:
        """The names of all episodes that are there, sorted; whether one is missing among them is not asked."""
        return sorted(path.name for path in self.path.glob(f"episodes/{'[0-9]' * 6}.npz"))

    def save_episode(self, index: int, episode: Episode) -> None:
        episode.save(self.episode_path(index))

    def foresight_paths(self) -> dict[int, Path]:
        """Predictions by episode, in order; none where the agent predicts nothing."""
        return {int(path.stem): path for path in sorted((self.path / "predictions").glob(f"{'[0-9]' * 6}.npz"))}

    def save_foresight(self, index: int, foresight: Foresight) -> None:
        folder = self.path / "predictions"
        folder.mkdir(exist_ok=True)
        foresight.save(folder / f"{index:06d}.npz")

    def poses(self) -> Iterator[np.ndarray]:
        """(T+1, 3) of every episode, without reading its images."""
        for path in self.episode_paths():
            yield read_arrays(path, ("pose",))["pose"]

    def metrics(self) -> list[dict[str, Any]]:
        """One dictionary an episode; a torn last line is left out."""
        rows = []
        for line in self.metrics_file.read_bytes().splitlines() if self.metrics_file.exists() else []:
            try:
                rows.append(json.loads(line))
            except ValueError:
                break
        return rows

    def append_metrics(self, row: dict[str, Any]) -> None:
        """One more row, on the disk before the checkpoint that counts on it."""
        with open(self.metrics_file, "a") as file:
            file.write(json.dumps(row) + "\n")
            file.flush()
            os.fsync(file.fileno())

    def write_metrics(self, rows: list[dict[str, Any]]) -> None:
        self.write("metrics.jsonl", "".join(json.dumps(row) + "\n" for row in rows))

    def refuse_gaps(self, episodes: int) -> None:
        """Raises RunFolderError where one of the first `episodes` episodes, or its metrics, is missing."""
        paths, rows = self.episode_paths(), self.metrics()
        if len(paths) < episodes:
            raise RunFolderError(f"{self.episode_path(len(paths))} is missing, so the run cannot go on. "
                                 "Restore it from a copy.")
        if [row.get("episode") for row in rows[:episodes]] != list(range(episodes)):
            raise RunFolderError(f"{self.metrics_file} ends after {len(rows)} of {episodes} episodes, "
                                 "so the run cannot go on. Restore it from a copy.")

    def refuse_holes(self) -> None:
        """Raises RunFolderError where an episode is missing that has later ones."""
        for index, name in enumerate(self.episode_names()):
            if name != self.episode_path(index).name:
                raise RunFolderError(f"{self.episode_path(index)} is missing, and {name} is there. "
                                     f"Restore it from a copy, or name what is left: data={self.path / 'episodes'}")

    def rewind(self, episodes: int) -> None:
        """Forget what came after the first `episodes` episodes. Raises RunFolderError if one is missing."""
        self.refuse_gaps(episodes)
        paths, rows = self.episode_paths(), self.metrics()
        later = [path for index, path in self.foresight_paths().items() if index >= episodes]
        for path in paths[episodes:] + later:
            path.unlink()
        self.write_metrics(rows[:episodes])


def nowhere(path: Path) -> str:
    """What is wrong with a path that is no folder."""
    return f"{path} is a file, and not the folder of a run." if path.exists() else f"There is no folder {path}."


def locked(file: IO[str], patience: float = 0.0) -> bool:
    """Whether the lock on this open file is ours now; who only asks whether it is free holds it for a moment."""
    until = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() >= until:
                return False
            time.sleep(0.05)
