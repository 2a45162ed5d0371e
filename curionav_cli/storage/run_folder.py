"""A run on disk. Everything that results draw is read from here; a save is finished or absent.

    config.yaml      every setting, resolved; with it the run can be repeated
    fixed.json       the settings that may not change when the run goes on
    run.json         command, versions, device, engine, git commit; when it was resumed, and by which commit
    status.json      state (running, done, failed, interrupted), episode, steps, coverage, error
    plan.npz         the floor plan: cells, start, obstacles
    metrics.jsonl    one object an episode; of offline training, one a save
    episodes/        000000.npz ...
    predictions/     000000.npz ... what the agent predicted of an episode before it learned from it
    checkpoint/      the state of the agent after the last two episodes
    figures/         heatmap.png, coverage.png, predictions.png, prediction_error.png
    table.md  results.csv
"""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from curionav_cli.errors import RunFolderError, SoundnessWarning
from curionav_cli.files import CRC32, read_arrays, read_json, write_bytes
from curionav_cli.records import Episode, FloorPlan, Prediction
from curionav_cli.safe_yaml import LOADER
from curionav_cli.storage.run_lock import already_in_use, is_locked, locked


class RunFolder:
    """The folder of a run: its paths, and reading and writing what is at them."""

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
            raise RunFolderError(no_folder(path))
        if not run.config.is_file():
            raise RunFolderError(f"{path} holds no run: it has no config.yaml. Give the folder of one run, "
                                 "such as outputs/DATE/TIME_small_room_random_0.")
        return run

    def locked(self) -> AbstractContextManager[None]:
        """Keep every other process out. Raises RunFolderError where one is in already."""
        return locked(self.path)

    def refuse_if_in_use(self) -> None:
        """Raises RunFolderError where a process is in it now."""
        if self.in_use:
            raise already_in_use(self.path)

    @property
    def in_use(self) -> bool:
        """Whether a process is in it now."""
        return is_locked(self.path)

    @classmethod
    def found(cls, path: Path) -> list[RunFolder]:
        """The run at `path`, or the runs of the sweep at `path`. Raises RunFolderError where there is none."""
        return cls.inside(path) or [cls.existing(path)]

    @classmethod
    def inside(cls, path: Path) -> list[RunFolder]:
        """The runs of the sweep at `path`; none where there is no sweep."""
        return [cls(file.parent) for file in sorted(path.glob("*/run.json"))
                if (file.parent / "config.yaml").is_file()]

    def refuse_without_config(self) -> None:
        """Raises RunFolderError where a run lacks its config.yaml: a new one is not written over it."""
        left = sorted(path for name in ("episodes/*.npz", "checkpoint/*/done", "metrics.jsonl")
                      for path in self.path.glob(name))
        if left and not self.config.is_file():
            raise RunFolderError(f"{self.path} holds {left[0].relative_to(self.path)} of a run, but no config.yaml. "
                                 "Restore that from a copy, or name another folder.")

    def create(self, config: str, fixed: dict[str, Any], about: dict[str, Any], plan: FloorPlan | None) -> None:
        """Begin the run. plan: None of offline training. config.yaml comes last: a folder that has it has the rest."""
        self.checkpoints.mkdir(parents=True, exist_ok=True)
        if plan:
            (self.path / "episodes").mkdir(exist_ok=True)
            self.figures.mkdir(exist_ok=True)
            plan.save(self.path / "plan.npz")
        self.write("fixed.json", json.dumps(fixed))
        self.write("run.json", json.dumps(about, indent=2))
        self.write("config.yaml", config)

    def write(self, name: str, text: str) -> None:
        """Write a text file of the run, whole or not at all."""
        write_bytes(self.path / name, text.encode())

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
        """Change values of status.json. A broken file is written anew: a resumed run counts again what stands in it."""
        try:
            before = self.status
        except RunFolderError as error:
            warnings.warn(f"{error} It is written anew.", SoundnessWarning, stacklevel=2)
            before = {}
        self.write("status.json", CRC32.sealed({**before, **changes}))

    @property
    def state(self) -> str:
        """running, done, failed or interrupted; a killed run left `running` behind and counts as interrupted."""
        state = str(self.status.get("state", "interrupted"))
        return "interrupted" if state == "running" and not self.in_use else state

    @property
    def plan(self) -> FloorPlan:
        """The floor plan. Raises RunFolderError where it is missing or broken."""
        path = self.path / "plan.npz"
        if not path.exists() and self.episode_names():
            raise RunFolderError(f"{path} is missing. Restore it from a copy.")
        if self.config.is_file() and not path.exists():
            raise RunFolderError(f"{self.path} has no plan.npz: offline training runs no episodes and has no coverage.")
        return FloorPlan.load(path)

    # -- episodes and metrics ---------------------------------------------------------------------

    def episode_path(self, index: int) -> Path:
        """Where episode `index` is, or would be."""
        return self.path / "episodes" / f"{index:06d}.npz"

    def episode_paths(self) -> list[Path]:
        """The episodes in order, up to the first that is missing."""
        paths: list[Path] = []
        while (path := self.episode_path(len(paths))).exists():
            paths.append(path)
        return paths

    def episode_names(self) -> list[str]:
        """The file names of all episodes that are there, sorted, also where one between them is missing."""
        return sorted(path.name for path in self.path.glob(f"episodes/{'[0-9]' * 6}.npz"))

    def save_episode(self, index: int, episode: Episode) -> None:
        """Write episode `index`."""
        episode.save(self.episode_path(index))

    def prediction_paths(self) -> dict[int, Path]:
        """Files of predictions by index of their episode, in order; none where the agent predicts nothing."""
        return {int(path.stem): path for path in sorted((self.path / "predictions").glob(f"{'[0-9]' * 6}.npz"))}

    def prediction_path(self, index: int) -> Path:
        """Where the prediction of episode `index` is, or would be."""
        return self.path / "predictions" / f"{index:06d}.npz"

    def save_prediction(self, index: int, prediction: Prediction) -> None:
        """Write the prediction of episode `index`."""
        path = self.prediction_path(index)
        path.parent.mkdir(exist_ok=True)
        prediction.save(path)

    def poses(self) -> Iterator[np.ndarray]:
        """Poses (T+1, 3) of every episode: x y in metres, yaw in radians. Reads no images."""
        for path in self.episode_paths():
            yield read_arrays(path, ("pose",))["pose"]

    def metrics(self) -> list[dict[str, Any]]:
        """The rows of metrics.jsonl, one an episode or save; a torn last line is left out."""
        rows = []
        for line in self.metrics_file.read_bytes().splitlines() if self.metrics_file.exists() else []:
            try:
                rows.append(json.loads(line))
            except ValueError:
                break
        return rows

    def append_metrics(self, row: dict[str, Any]) -> None:
        """Append a row to metrics.jsonl; it is on the disk before the checkpoint that relies on it."""
        with open(self.metrics_file, "a") as file:
            file.write(json.dumps(row) + "\n")
            file.flush()
            os.fsync(file.fileno())

    def write_metrics(self, rows: list[dict[str, Any]]) -> None:
        """Replace metrics.jsonl."""
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
        """Remove what came after the first `episodes` episodes. Raises RunFolderError if one of these is missing."""
        self.refuse_gaps(episodes)
        paths, rows = self.episode_paths(), self.metrics()
        later = [path for index, path in self.prediction_paths().items() if index >= episodes]
        for path in paths[episodes:] + later:
            path.unlink()
        self.write_metrics(rows[:episodes])


def no_folder(path: Path) -> str:
    """What is wrong with a path that is no folder."""
    return f"{path} is a file, and not the folder of a run." if path.exists() else f"There is no folder {path}."
