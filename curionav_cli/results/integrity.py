"""The readable part of a run, and a line about each thing that is missing or broken."""

from __future__ import annotations

import os
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

END = 22  # bytes of the record that a zip ends with


@dataclass(frozen=True)
class ReadablePart:
    """The part of a run that can be shown.

    ends: steps after 0 to E readable episodes. status: {} where it cannot be read. lost: a line about the first
    episode that cannot; gaps: a line about everything that is missing.
    """

    curve: Curve
    ends: list[int]
    status: dict[str, Any]
    lost: str
    gaps: tuple[str, ...]


@dataclass(frozen=True)
class Readable(ReadablePart):
    """The part that can be shown, with the visits to every cell."""

    coverage: Coverage


def readable(run: RunFolder, plan: FloorPlan, rule: str, denominator: str) -> Readable:
    """Count a run by this rule and denominator; its poses are read once."""
    coverage = Coverage(plan, rule, denominator)
    status, broken = status_of(run)
    ends, lost = count(run, coverage, status.get("episode", 0))
    gaps = tuple(filter(None, (broken, lost, torn_line(run, run.metrics()))))
    return Readable(coverage.curve(), ends, status, lost, gaps, coverage)


def noted(run: RunFolder, plan: FloorPlan, rows: Sequence[dict[str, Any]]) -> ReadablePart | None:
    """Read a whole run as it counted itself, by landing on visitable cells; rows: its metrics.

    Of episode files only the ends are read, which a file that was cut short lacks.

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
        curve = Curve(np.array(found, np.int64), ends[-1], plan.total())
        sound = (np.diff([0, *found, ends[-1]]) >= 0).all() and (np.diff(ends) > 0).all()
    except (LookupError, TypeError, ValueError, OverflowError):
        return None
    folder = str(run.episode_path(0).parent)
    whole = sound and not torn_line(run, rows) and all(ends_whole(f"{folder}/{name}") for name in names)
    return ReadablePart(curve, ends, status, "", ()) if whole else None


def ends_whole(path: str) -> bool:
    """Whether the file ends as a zip without a comment does. In system calls: a comparison asks it of 120 000 files."""
    file = os.open(path, os.O_RDONLY)
    try:
        return os.pread(file, 4, max(0, os.fstat(file).st_size - END)) == b"PK\x05\x06"
    finally:
        os.close(file)


def status_of(run: RunFolder) -> tuple[dict[str, Any], str]:
    """Read status.json; returns {} and a line about it where it is broken."""
    try:
        return run.status, ""
    except RunFolderError as error:
        return {}, str(error)


def count(run: RunFolder, coverage: Coverage, noted: int) -> tuple[list[int], str]:
    """Count episodes up to the first that is missing or broken: steps after each, and a line about that one.

    noted: number of finished episodes by the run's status.
    """
    ends, lost = [0], ""
    last = max([noted, *(int(Path(name).stem) + 1 for name in run.episode_names())])  # it may go on meanwhile
    for path in run.episode_paths():
        try:
            coverage.add(read_arrays(path, ("pose",))["pose"])
        except RunFolderError as error:
            lost = str(error)
            break
        ends.append(coverage.steps)
    first = len(ends) - 1
    if not lost and first < last:
        lost = f"{run.episode_path(first)} is missing."
    return ends, lost and f"{lost} Shown up to there, {coverage.steps:,} steps."


def torn_line(run: RunFolder, rows: Sequence[dict[str, Any]]) -> str:
    """A line about the end of metrics.jsonl, where it cannot be read. rows: those that can."""
    if not run.metrics_file.exists():
        return f"{run.metrics_file} is missing; what the run cost is not known"
    lines = run.metrics_file.read_bytes().splitlines()
    return f"{run.metrics_file}: line {len(rows) + 1} is torn; what it cost from there on is not known" \
        if len(lines) > len(rows) else ""
