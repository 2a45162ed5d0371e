"""What of a run can be read, and a line about each thing that is missing or broken."""

from __future__ import annotations

from typing import Any, NamedTuple

from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_arrays
from curionav_cli.records import FloorPlan
from curionav_cli.results.coverage import Coverage
from curionav_cli.storage.run_folder import RunFolder


class Readable(NamedTuple):
    """The part of a run that can be shown.

    ends: steps lived after 0 to E readable episodes. status: {} where it cannot be read. lost: a line about the first
    episode that cannot; gaps: a line about everything that is missing.
    """

    coverage: Coverage
    ends: list[int]
    status: dict[str, Any]
    lost: str
    gaps: tuple[str, ...]


def readable(run: RunFolder, plan: FloorPlan, rule: str, denominator: str) -> Readable:
    """Poses are read once and counted by this rule and denominator."""
    coverage = Coverage(plan, rule, denominator)
    status, broken = status_of(run)
    ends, lost = count(run, coverage, status.get("episode", 0))
    return Readable(coverage, ends, status, lost, tuple(filter(None, (broken, lost, torn_line(run)))))


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


def torn_line(run: RunFolder) -> str:
    """A line about the end of metrics.jsonl, where it cannot be read."""
    lines = run.metrics_file.read_text().splitlines() if run.metrics_file.exists() else []
    rows = len(run.metrics())
    return f"{run.metrics_file}: line {rows + 1} is torn; what was spent from there on is not known" \
        if len(lines) > rows else ""
