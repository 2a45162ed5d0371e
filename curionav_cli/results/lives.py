"""Runs as a comparison needs them: poses read once, and what is missing named instead of hidden."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.errors import RunFolderError
from curionav_cli.records import read_arrays, read_json
from curionav_cli.results.arms import Settings, arm_settings, world_settings
from curionav_cli.results.coverage import Coverage, Curve
from curionav_cli.results.runs import Run, job_number, spent
from curionav_cli.storage.run_folder import RunFolder


@dataclass(frozen=True, eq=False)
class Life:
    """One run, small enough to keep a hundred.

    ends: (E + 1,) steps lived after 0 to E episodes. budget: what was spent by then, (E + 1,) of each part, nan
    where it is not known. whole: lived to its end, and no episode is missing. gaps: what is missing, a line each.
    """

    folder: Path
    scene: str
    agent: str
    seed: int
    preset: str
    arm: Settings
    world: Settings
    curve: Curve
    ends: np.ndarray
    budget: dict[str, np.ndarray]
    state: str
    error: str
    whole: bool
    gaps: tuple[str, ...]

    @property
    def steps(self) -> int:
        return int(self.ends[-1])

    def spent(self, steps: int) -> dict[str, float]:
        """The budget of the first `steps` steps, with the learning after the episode that they end in."""
        episodes = int(np.searchsorted(self.ends, steps))
        return {key: float(sums[episodes]) for key, sums in self.budget.items()}


def folders(path: Path) -> list[Path]:
    """The run at `path`, or every job of the sweep there, those that never began too, by their numbers.

    Raises RunFolderError where there is neither.
    """
    if (path / "config.yaml").is_file():
        return [path]
    jobs = {mark.parent for name in (".hydra", "run.json") for mark in path.glob(f"*/{name}")}
    if not path.is_dir():
        raise RunFolderError(f"There is no folder {path}.")
    if not jobs:
        raise RunFolderError(f"{path} holds neither a run nor a sweep.")
    return sorted(jobs, key=lambda job: job_number(job.name))


def read(folder: Path, rule: str, denominator: str) -> Life:
    """The run in `folder`. Raises RunFolderError where nothing of it can be shown."""
    if not (folder / "config.yaml").is_file():
        raise RunFolderError(f"{folder} did not begin; if it failed, its log says why")
    run = Run.open(folder)
    fixed, plan = read_json(folder / "fixed.json"), run.plan
    coverage = Coverage(plan, rule, denominator)
    status, gap = status_of(run.folder)
    state, error = status.get("state") or "unknown", status.get("error") or ""
    ends, lost = count(run.folder, coverage, status.get("episode", 0))
    if len(ends) == 1:
        raise RunFolderError("; ".join([f"{folder} has no finished episode ({state})", *filter(None, [error, lost])]))
    metrics = run.folder.metrics()
    torn = torn_line(run.folder, len(metrics))
    budget = {key: np.append(sums, np.full(max(0, len(ends) - len(sums)), np.nan))
              for key, sums in spent(metrics).items()}
    return Life(folder, run.env, run.agent, run.seed, run.preset, arm_settings(fixed), world_settings(fixed),
                coverage.curve(), np.array(ends), budget, state, error, state == "done" and not lost,
                tuple(filter(None, (gap, lost, torn))))


def status_of(run: RunFolder) -> tuple[dict[str, Any], str]:
    """status.json, and what is wrong with it."""
    try:
        return run.status, ""
    except RunFolderError as error:
        return {}, str(error)


def count(run: RunFolder, coverage: Coverage, noted: int) -> tuple[list[int], str]:
    """Count episodes up to the first that is missing or broken: steps after each, and a line about that one.

    noted: episodes that the run said it had finished.
    """
    ends, lost = [0], ""
    for path in run.episode_paths():
        try:
            coverage.add(read_arrays(path, ("pose",))["pose"])
        except RunFolderError as error:
            lost = str(error)
            break
        ends.append(coverage.steps)
    first = len(ends) - 1
    there = [int(path.stem) for path in run.path.glob(f"episodes/{'[0-9]' * 6}.npz")]
    if not lost and first < max([noted, *(index + 1 for index in there)]):
        lost = f"{run.episode_path(first)} is missing."
    return ends, lost and f"{lost} Shown up to there, {coverage.steps:,} steps."


def torn_line(run: RunFolder, rows: int) -> str:
    """A line about the end of metrics.jsonl, where it cannot be read."""
    lines = run.metrics_file.read_text().splitlines() if run.metrics_file.exists() else []
    return f"{run.metrics_file}: line {rows + 1} is torn; what was spent from there on is not known" \
        if len(lines) > rows else ""
