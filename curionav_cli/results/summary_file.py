"""A run in one small file: what it covered and what it cost, without its episodes.

`curionav export RUN --to summary` writes it, as NAME.summary.npz; `curionav compare` and `curionav paper figures` read
it in place of the run's folder. It holds arrays: `found` and `ends`, as differences; `visits` to every cell; the floor
plan; and `run`, JSON text: settings, what run.json says of versions and commits, the state, and what was spent.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.errors import RunFolderError
from curionav_cli.files import SMALL, disk, read_arrays, read_json, understood, write_arrays
from curionav_cli.records import PLAN_ARRAYS, PLAN_OPTIONAL, FloorPlan
from curionav_cli.results.coverage import Coverage
from curionav_cli.results.integrity import Readable
from curionav_cli.results.runs import Run, known, spent
from curionav_cli.storage.run_folder import RunFolder

SUFFIX = ".summary.npz"
COUNTED = ("landing", "visitable")  # as a run counts itself as it goes
ARRAYS = ("found", "ends", "visits", "run")
TEXTS = ("settings", "fixed", "about", "status", "spent")  # objects in `run`


@dataclass(frozen=True)
class SummaryFile:
    """What a summary file holds.

    plan: the floor plan. found: (visited,) sorted steps at which a new cell was visited. ends: (E + 1,) steps after 0
    to E episodes. visits: (rows, columns). settings: env, agent, robot, seed, scale. fixed: as in fixed.json. about: of
    run.json. status: state, error, explored_at. spent: CPU-seconds and others until the end; what is not known is
    absent. lost, gaps: what could not be read of the run. disk: bytes of its folder.
    """

    plan: FloorPlan
    found: np.ndarray
    ends: np.ndarray
    visits: np.ndarray
    settings: dict[str, Any]
    fixed: dict[str, Any]
    about: dict[str, Any]
    status: dict[str, Any]
    spent: dict[str, float]
    lost: str
    gaps: tuple[str, ...]
    disk: int

    def save(self, path: Path) -> None:
        """Write the file, whole or not at all; the same bytes for the same run."""
        text = {key: getattr(self, key) for key in (*TEXTS, "lost", "gaps", "disk")}
        write_arrays(path, {
            **self.plan.arrays(), "found": np.diff(self.found, prepend=0).astype(np.int32),
            "ends": np.diff(self.ends).astype(np.int32), "visits": self.visits.astype(np.uint32),
            "run": np.array(json.dumps(text)),
        }, SMALL)

    @classmethod
    def load(cls, path: Path) -> SummaryFile:
        """Read what `save` wrote. Raises RunFolderError where the file is missing or broken."""
        arrays = read_arrays(path, (*PLAN_ARRAYS, *ARRAYS), PLAN_OPTIONAL)
        with understood(path):
            plan, text = FloorPlan.of(arrays), json.loads(str(arrays["run"]))
            found, ends = (np.cumsum(arrays[name], dtype=np.int64) for name in ("found", "ends"))
            visits = arrays["visits"].astype(np.int64)
            if visits.shape != plan.visitable.shape or not len(ends) or len(found) != (visits > 0).sum():
                raise ValueError("its arrays are not of one run")
            objects = [text[key] for key in TEXTS] + [text["settings"][key] for key in ("env", "agent")]
            if not all(isinstance(one, Mapping) for one in objects) or not {"seed", "scale"} <= text["settings"].keys():
                raise ValueError("its texts are not of a run")
            return cls(plan, found, np.append(0, ends), visits, **{key: text[key] for key in TEXTS}, lost=text["lost"],
                       gaps=tuple(text["gaps"]), disk=text["disk"])


class SummarisedRun(Run):
    """A run as its summary file has it: settings, floor plan and coverage, and no episodes."""

    @cached_property
    def file(self) -> SummaryFile:
        if (self.rule, self.denominator) != COUNTED:
            raise RunFolderError(f"{self.folder.path} is the summary of a run, which counts visitable cells by landing "
                                 "alone. Give the run's folder to count others")
        return SummaryFile.load(self.folder.path)

    @cached_property
    def config(self) -> dict[str, Any]:
        return self.file.settings

    @property
    def state(self) -> str:
        return str(self.file.status.get("state", "unknown"))

    @cached_property
    def plan(self) -> FloorPlan:
        return self.file.plan

    @cached_property
    def readable(self) -> Readable:
        coverage = Coverage(self.plan, self.rule, self.denominator)
        coverage.visits, coverage.steps, coverage.first = self.file.visits, int(self.file.ends[-1]), [self.file.found]
        return Readable(coverage.curve(), self.file.ends.tolist(), self.file.status, self.file.lost, self.file.gaps,
                        coverage)

    @property
    def episodes(self) -> list[Path]:
        """Raises RunFolderError: they are not in the file."""
        raise RunFolderError(f"{self.folder.path} is the summary of a run, without its episodes. Give its folder.")

    @property
    def predictions(self) -> dict[int, Path]:
        return {}


def summarised(folder: Path, about: Mapping[str, Any]) -> SummaryFile:
    """What a summary file holds of the run in `folder`, which has a finished episode. about: of its run.json.

    Raises RunFolderError where it cannot be read.
    """
    run = Run(RunFolder(folder))
    status = {key: run.readable.status.get(key) for key in ("state", "error", "explored_at")} | {"state": run.state}
    lost, *gaps = (line.replace(f"{folder}/", f"{folder.name}/") for line in (run.readable.lost, *run.readable.gaps))
    return SummaryFile(run.plan, run.curve.found, np.array(run.readable.ends), run.coverage.visits, run.config,
                       read_json(folder / "fixed.json"), dict(about), status, spent_by_end(run.folder),
                       lost, tuple(gaps), disk(folder))


def spent_by_end(run: RunFolder) -> dict[str, float]:
    """What a run cost until its end, as `runs.spent` has it; without what was not noted."""
    metrics = run.metrics()
    sums = {key: known(each[-1]) for key, each in spent(metrics).items()} if metrics else {}
    return {key: total for key, total in sums.items() if total is not None}


def is_summary(path: Path) -> bool:
    """Whether a path names a summary file."""
    return path.name.endswith(SUFFIX) and not path.is_dir()


def opened(path: Path, rule: str = COUNTED[0], denominator: str = COUNTED[1], variant: str = "",
           world: str = "") -> Run:
    """The run at `path`, a folder or a summary file, as results read it."""
    kind = SummarisedRun if is_summary(path) else Run
    return kind(RunFolder(path), rule, denominator, variant, world)
