"""What of a run can be read, and a line about each thing that is missing or broken."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_arrays
from curionav_cli.records import FloorPlan
from curionav_cli.results.coverage import Coverage, Curve
from curionav_cli.storage.run_folder import RunFolder


@dataclass(frozen=True)
class Told:
    """The part of a run that can be shown.

    ends: steps lived after 0 to E readable episodes. status: {} where it cannot be read. lost: a line about the first
    episode that cannot; gaps: a line about everything that is missing.
    """

    curve: Curve
    ends: list[int]
    status: dict[str, Any]
    lost: str
    gaps: tuple[str, ...]


@dataclass(frozen=True)
class Readable(Told):
    """The same with the visits to every cell."""

    coverage: Coverage


def readable(run: RunFolder, plan: FloorPlan, rule: str, denominator: str) -> Readable:
    """Poses are read once and counted by this rule and denominator."""
    coverage = Coverage(plan, rule, denominator)
    status, broken = status_of(run)
    ends, lost = count(run, coverage, status.get("episode", 0))
    gaps = tuple(filter(None, (broken, lost, torn_line(run, run.metrics()))))
    return Readable(coverage.curve(), ends, status, lost, gaps, coverage)


def noted(run: RunFolder, plan: FloorPlan, rows: Sequence[dict[str, Any]]) -> Told | None:
    """A whole run as it counted itself, by landing on visitable cells; rows: its metrics. No episode is opened.

    None where status, rows and files are not about the same episodes, where rows lack what was found (older ones do)
    or contradict themselves.
    """
    status, broken = status_of(run)
    names = [run.episode_path(index).name for index in range(len(rows))]
    if broken or not rows or status.get("episode") != len(rows) or run.episode_names() != names:
        return None
    found: list[int] = []
    try:
        for index, row in enumerate(rows):
            found += row["found"]
            if (row["episode"], row["visited"]) != (index, len(found)):
                return None
        ends = [0, *(row["steps"] for row in rows)]
        curve = Curve(np.array(found, np.int64), ends[-1], int(plan.visitable.sum()))
        sound = (np.diff([0, *found, ends[-1]]) >= 0).all() and (np.diff(ends) > 0).all()
    except (LookupError, TypeError, ValueError, OverflowError):
        return None
    return Told(curve, ends, status, "", ()) if sound and not torn_line(run, rows) else None


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
    if not lost and first < max([noted, *(int(Path(name).stem) + 1 for name in run.episode_names())]):
        lost = f"{run.episode_path(first)} is missing."
    return ends, lost and f"{lost} Shown up to there, {coverage.steps:,} steps."


def torn_line(run: RunFolder, rows: Sequence[dict[str, Any]]) -> str:
    """A line about the end of metrics.jsonl, where it cannot be read. rows: those that can."""
    lines = run.metrics_file.read_bytes().splitlines() if run.metrics_file.exists() else []
    return f"{run.metrics_file}: line {len(rows) + 1} is torn; what was spent from there on is not known" \
        if len(lines) > len(rows) else ""
