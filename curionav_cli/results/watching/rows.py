"""The rows of a metrics.jsonl that grows: what was read before is not read again."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

POINTS = 160  # of a curve, about as many as a phone has dots
STEPS = ("steps", "iterations")  # what the rows of a run count


class Rows:
    """The whole rows of a metrics.jsonl, read as they are appended."""

    def __init__(self, path: Path):
        self.path = path
        self.rows: list[dict[str, Any]] = []
        self.read, self.file = 0, 0  # bytes that were read, and the file's number on the disk
        self.curve: tuple[Any, list[tuple[int, float]]] = (None, [])  # the last that was asked for

    def update(self) -> None:
        """Read what was appended; a file that was replaced, as by a resumed run, is read anew."""
        try:
            found = self.path.stat()
            if (found.st_ino, found.st_size) == (self.file, self.read):
                return
            if found.st_ino != self.file or found.st_size < self.read:
                self.rows, self.read, self.file = [], 0, found.st_ino
            with open(self.path, "rb") as file:
                file.seek(self.read)
                whole = file.read().rpartition(b"\n")
        except OSError:
            self.rows, self.read, self.file = [], 0, 0
            return
        self.read += len(whole[0] + whole[1])
        self.rows += [row for line in whole[0].splitlines() if isinstance(row := parsed(line), dict)]

    def names(self) -> list[str]:
        """The metrics that the last row has a number of, coverage first."""
        if not self.rows:
            return []
        numbers = [key for key, value in self.rows[-1].items() if is_number(value) and key not in (*STEPS, "episode")]
        return sorted(numbers, key=lambda key: (key != "coverage", key))

    def points(self, metric: str) -> list[tuple[int, float]]:
        """(step, value) of a metric, at most POINTS of them and always the last."""
        if self.curve[0] != (metric, self.file, self.read):
            self.curve = (metric, self.file, self.read), self.thinned(metric)
        return self.curve[1]

    def thinned(self, metric: str) -> list[tuple[int, float]]:
        found = [(step(row), row[metric]) for row in self.rows if is_number(row.get(metric))]
        every = max(1, math.ceil(len(found) / POINTS))
        return found[(len(found) - 1) % every::every] if found else []

    def seconds(self) -> float | None:
        """Seconds that one of the last ten rows took; None where rows do not say."""
        took = [sum(row.get(f"seconds_{what}", 0.0) for what in ("acting", "learning")) for row in self.rows[-10:]]
        return sum(took) / len(took) if took and sum(took) > 0 else None


def parsed(line: bytes) -> Any:
    """A line as JSON; None for a broken one."""
    try:
        return json.loads(line)
    except ValueError:
        return None


def step(row: dict[str, Any]) -> int:
    return next((int(row[key]) for key in STEPS if key in row), 0)


def is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


def stamp(path: Path) -> tuple[int, int]:
    """When a file was last written and its bytes; zeros where it is not there."""
    try:
        found = path.stat()
    except OSError:
        return 0, 0
    return found.st_mtime_ns, found.st_size
