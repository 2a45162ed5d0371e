"""Show a running sweep: on a terminal a table of all runs, elsewhere a line whenever the state of a run changes.

The states are read from the status.json of each run.
"""

from __future__ import annotations

import sys
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.live import Live
from rich.table import Table

from curionav_cli.config.compose import Plan
from curionav_cli.errors import RunFolderError
from curionav_cli.execution.progress import duration
from curionav_cli.results.runs import job_number
from curionav_cli.results.tables import percent
from curionav_cli.storage.run_folder import RunFolder

EVERY = 0.5  # seconds between two readings
DONE, PLANNED = ("episode", "iteration", "homecoming"), ("episodes", "iterations", "requests")  # in status.json
FIRST = ("running", "failed", "interrupted", "done")  # the order in the table


@dataclass
class SweepMonitor:
    """The states of a sweep of `jobs` runs, as last read."""

    folder: Path
    jobs: int
    rows: dict[str, dict[str, Any]] = field(default_factory=dict)
    began: dict[str, tuple[float, float]] = field(default_factory=dict)  # when first seen running, and how far

    def update(self) -> list[str]:
        """Read all states again; returns the names of runs whose state changed."""
        changed = []
        for path in sorted(self.folder.glob("*/status.json"), key=lambda path: job_number(path.parent.name)):
            name = path.parent.name
            try:
                row = RunFolder(path.parent).status
            except RunFolderError:
                continue
            if self.rows.get(name, {}).get("state") != row.get("state"):
                changed.append(name)
                self.began[name] = (time.monotonic(), done(row))
            self.rows[name] = row
        return changed

    def left(self, name: str) -> str:
        """The time that a running run still takes, at the pace seen so far; ? where none was seen."""
        row = self.rows[name]
        since, first = self.began[name]
        made = done(row) - first
        return duration((time.monotonic() - since) / made * (planned(row) - done(row))) if made > 0 else "?"

    def line(self, name: str) -> str:
        """One run in a line: '2_small_room_random_1: running, 3/10, coverage 12.3 %'."""
        row = self.rows[name]
        parts = [str(row.get("state")), progress(row), *([f"coverage {coverage(row)}"] if coverage(row) else [])]
        return f"{name}: {', '.join(parts)}" + (f": {row['error']}" if row.get("error") else "")

    def count(self) -> str:
        """All runs in a line: '6 runs: 2 running, 1 done, 3 waiting'."""
        states = Counter(str(row.get("state")) for row in self.rows.values())
        states["waiting"] = max(0, self.jobs - len(self.rows))
        return f"{self.jobs} runs: " + ", ".join(f"{states[state]} {state}" for state in [*FIRST, "waiting"]
                                                 if states[state])

    def table(self, height: int) -> Table:
        """A table of as many runs as fit into `height` lines, the running and the failed ones first."""
        made = Table.grid(padding=(0, 2))
        rank = {state: place for place, state in enumerate(FIRST)}
        names = sorted(self.rows, key=lambda name: (rank.get(self.rows[name].get("state", ""), 0), job_number(name)))
        for name in names[:max(1, height - 2)]:
            row = self.rows[name]
            running = row.get("state") == "running"
            made.add_row(name, str(row.get("state")), progress(row), coverage(row),
                         f"{self.left(name)} left" if running else str(row.get("error") or "")[:60])
        made.add_row(self.count())
        return made


def done(row: dict[str, Any]) -> float:
    return next((row[key] for key in DONE if key in row), 0)


def planned(row: dict[str, Any]) -> float:
    return next((row[key] for key in PLANNED if key in row), 0)


def progress(row: dict[str, Any]) -> str:
    return f"{done(row)}/{planned(row)}"


def coverage(row: dict[str, Any]) -> str:
    return percent(row["coverage"]) if row.get("coverage") is not None else ""


@contextmanager
def monitored(todo: Plan) -> Iterator[None]:
    """Show a sweep whose runs are in other processes; a run in this one shows its own progress."""
    if not todo.beside:
        yield
        return
    console, over = Console(), threading.Event()
    monitor = SweepMonitor(todo.folder, (todo.engine.trials or 0) if todo.engine else len(todo.jobs))
    drawn = Live(console=console, auto_refresh=False, transient=True) if sys.stdout.isatty() else nullcontext()
    with drawn as live:
        watch = threading.Thread(target=keep_updating, args=(monitor, over, live), daemon=True)
        watch.start()
        try:
            yield
        finally:
            over.set()
            watch.join()


def keep_updating(monitor: SweepMonitor, over: threading.Event, live: Live | None) -> None:
    """Show the states until `over`, and then once more."""
    last = False
    while not last:
        last = over.wait(EVERY)
        changed = monitor.update()
        if live:
            live.update(monitor.table(live.console.height), refresh=True)
        elif changed:
            with suppress(BrokenPipeError):  # the runs write there too, and end because of it
                print("\n".join(monitor.line(name) for name in changed), monitor.count(), sep="\n", flush=True)
