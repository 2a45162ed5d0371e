"""Runs as a comparison needs them: poses are read once, and what is missing is named."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_json
from curionav_cli.results.coverage import Curve
from curionav_cli.results.docking import came_home
from curionav_cli.results.integrity import ReadablePart, noted
from curionav_cli.results.labels import Settings, arm_settings, world_settings
from curionav_cli.results.runs import Run, job_number, spent
from curionav_cli.results.summary_file import COUNTED, SUFFIX, SummarisedRun, is_summary, opened
from curionav_cli.storage.run_folder import no_folder


@dataclass(frozen=True, eq=False)
class RunSummary:
    """One run, small enough to keep a hundred.

    env: its name and map. ends: (E + 1,) steps after 0 to E episodes. budget: what was spent by then, (E + 1,) of
    each part, nan where it is not known. whole: it is done, and no episode is missing. gaps: what is missing, a
    line each. seed: of an evaluation "trained run's / its own", as in "3 / 0". explored: the step at which the agent
    said that nothing was left, if it did.
    """

    folder: Path
    env: Settings
    agent: str
    seed: int | str
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
    explored: int | None = None

    @property
    def steps(self) -> int:
        return int(self.ends[-1])

    @property
    def evaluates(self) -> bool:
        """Whether its agent was trained before, and does not learn here."""
        return isinstance(self.seed, str)

    def spent(self, steps: int) -> dict[str, float]:
        """Budget of the first `steps` steps, with the learning after the episode that they end in."""
        episodes = int(np.searchsorted(self.ends, steps))
        return {key: float(sums[episodes]) for key, sums in self.budget.items()}


def folders(path: Path) -> list[Path]:
    """Find the run at `path`, or every job of the sweep there, those that never began too, by their numbers. A run's
    summary file stands for it, and a folder of them for a sweep.

    Raises RunFolderError where there is none of these.
    """
    if (path / "config.yaml").is_file() or (path.is_file() and is_summary(path)):
        return [path]
    if path.is_file():
        raise RunFolderError(f"{path} is a file, and neither the folder of a run nor a summary: the name of one ends "
                             f"in {SUFFIX}")
    jobs = {mark.parent for name in (".hydra", "run.json") for mark in path.glob(f"*/{name}")}
    if not path.is_dir():
        raise RunFolderError(no_folder(path))
    jobs |= set(path.glob(f"*{SUFFIX}"))
    if not jobs:
        raise RunFolderError(f"{path} holds neither a run nor a sweep, nor summaries of runs.")
    return sorted(jobs, key=lambda job: job_number(job.name))


def read(folder: Path, rule: str, denominator: str) -> RunSummary:
    """Read the run in `folder`, or of its summary file. Raises RunFolderError where nothing of it can be shown."""
    run = opened(folder, rule, denominator)
    if isinstance(run, SummarisedRun):
        return summarised(run)
    if not (folder / "config.yaml").is_file():
        raise RunFolderError(f"{folder} did not begin; if it failed, its log says why")
    if not run.plan.bounded:
        raise RunFolderError(f"{folder} explored a real floor without a map of it (env.floor), so its coverage is a "
                             "number of cells, and no share that can be compared")
    fixed, metrics = read_json(folder / "fixed.json"), run.folder.metrics()
    found = (noted(run.folder, run.plan, metrics) if (rule, denominator) == COUNTED else None) or run.readable
    if len(found.ends) == 1 and came_home(run.folder):
        raise RunFolderError(f"{folder} is a test of docking (curionav dock), which counts no coverage")
    if len(found.ends) == 1:
        raise RunFolderError("; ".join([f"{folder} has no finished episode ({found.status.get('state') or 'unknown'})",
                                        *filter(None, [found.status.get("error"), found.lost])]))
    budget = {key: np.append(sums, np.full(max(0, len(found.ends) - len(sums)), np.nan))
              for key, sums in spent(metrics).items()}
    return summary(run, fixed, found, budget)


def summarised(run: SummarisedRun) -> RunSummary:
    """Read a summary file: of its budget only what was spent by its end. Raises RunFolderError where it is broken."""
    file = run.file
    budget = {key: np.array([0.0, *[np.nan] * (len(file.ends) - 2), file.spent.get(key, np.nan)]) for key in spent([])}
    return summary(run, file.fixed, run.readable, budget)


def summary(run: Run, fixed: Settings, found: ReadablePart, budget: dict[str, np.ndarray]) -> RunSummary:
    """What was read of a run, by the names that a comparison has for it."""
    state, error = found.status.get("state") or "unknown", found.status.get("error") or ""
    seed = f"{fixed['training seed']} / {run.seed}" if "training seed" in fixed else run.seed
    return RunSummary(run.folder.path, run.config["env"], run.agent, seed, run.preset, arm_settings(fixed),
                      world_settings(fixed), found.curve, np.array(found.ends), budget, state, error,
                      state == "done" and not found.lost, found.gaps, found.status.get("explored_at"))
