"""curionav runs [DIR...] [--state failed] [--sort coverage]: a table of the runs in outputs/."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from curionav_cli.commands.arguments import sorted_out
from curionav_cli.commands.summary import print_columns
from curionav_cli.errors import ConfigError, UserError
from curionav_cli.execution.progress import duration
from curionav_cli.execution.screen import a_console
from curionav_cli.execution.sweep_monitor import DONE, PLANNED
from curionav_cli.storage.run_folder import RunFolder

OUTPUTS = Path("outputs")
STATES = ("running", "done", "failed", "interrupted", "broken")
SORTS = ("age", "coverage", "size", "state", "env", "agent", "seed", "run")
CHOICES: dict[str, tuple[str, ...]] = {"state": STATES, "env": (), "agent": (), "seed": (), "sort": SORTS}
COLUMNS = (("run", "run", "{}"), ("state", "state", "{}"), ("env", "env", "{}"), ("agent", "agent", "{}"),
           ("seed", "seed", "{}"), ("done", "progress", "{}"), ("coverage", "coverage", "{:.1%}"),
           ("age", "age", "{}"), ("size", "size", "{}"))
SHOWN = ("run", "state", "coverage", "age", "size", "done", "env", "agent", "seed")  # as many as there is room for
DESCENDING = ("coverage", "size")


@dataclass(frozen=True)
class Found:
    """A run on the disk. seconds: since something in it was last written; size: bytes on the disk."""

    path: Path
    state: str
    env: str
    agent: str
    seed: int
    progress: str
    coverage: float | None
    seconds: float
    size: int
    error: str

    def row(self) -> dict[str, Any]:
        """Its row in the table."""
        return {"run": str(self.path), **vars(self), "age": age(self.seconds), "size": megabytes(self.size)}

    def key(self, sort: str) -> Any:
        """Its sort key."""
        value = {"age": self.seconds, "run": str(self.path), "state": STATES.index(self.state)}
        key = value.get(sort, getattr(self, sort, None))
        return -1 if key is None else key


def run(words: list[str]) -> int:
    """Print the table; returns the exit code. words: folders (by default outputs), and settings of CHOICES."""
    folders, chosen = sorted_out("runs", words, CHOICES)
    roots = folders or [OUTPUTS]
    for root in roots:
        if not root.is_dir():
            raise ConfigError(f"There is no folder {root}. Name one, as in: curionav runs outputs"
                              + ("" if folders else ". By default outputs/ in this directory is searched."))
    sort = chosen.pop("sort", "age")
    found = [run for root in roots for path in run_folders(root) if fits(run := read(path), chosen)]
    found.sort(key=lambda run: run.key(sort), reverse=sort in DESCENDING)
    console = a_console()
    if not found:
        console.print(f"No run in {', '.join(map(str, roots))}{' matches' if chosen else ''}.", highlight=False)
        return 0
    asked = [key for key in (*chosen, sort) if key in SHOWN]
    print_columns([run.row() for run in found], COLUMNS, console, list(dict.fromkeys(["run", *asked, *SHOWN])))
    for run in found:
        if run.error and run.state != "done":
            console.print(f"{run.path}: {run.error}", soft_wrap=True, highlight=False, markup=False)
    count = f"{len(found)} run{'s' * (len(found) != 1)}"
    console.print(f"{count}, {megabytes(sum(run.size for run in found))}", highlight=False)
    return 0


def run_folders(root: Path) -> Iterator[Path]:
    """Folders with a run in or below `root`; not those inside a run."""
    for folder, inner, files in os.walk(root):
        if "run.json" in files or "status.json" in files:
            inner.clear()
            yield Path(folder)


def read(path: Path) -> Found:
    """Read one run; where that fails its state is broken, with the error."""
    run, state, error = RunFolder(path), "broken", ""
    status: dict[str, Any] = {}
    settings: dict[str, Any] = {"env": {"name": "?"}, "agent": {"name": "?"}, "seed": -1}
    try:
        status, state = run.status, run.state
        error = str(status.get("error") or "")
        if run.config.is_file():
            settings = run.settings
    except UserError as unreadable:
        state, error = "broken", str(unreadable)
    done, planned = (next((status[key] for key in keys if key in status), None) for keys in (DONE, PLANNED))
    newest, size = measured(path)
    return Found(path, state if state in STATES else "broken", settings["env"]["name"], settings["agent"]["name"],
                 settings["seed"], "-" if planned is None else f"{done}/{planned}", status.get("coverage"),
                 time.time() - newest, size, error)


def measured(folder: Path) -> tuple[float, int]:
    """The time of the last write, and bytes on the disk; files that vanish meanwhile are left out."""
    stats = [folder.lstat()]
    for root, folders, files in os.walk(folder):
        for name in (*folders, *files):
            with suppress(FileNotFoundError):
                stats.append(Path(root, name).lstat())
    return max(stat.st_mtime for stat in stats), sum(stat.st_blocks * 512 for stat in stats)


def fits(found: Found, chosen: dict[str, str]) -> bool:
    return all(str(getattr(found, key)) == value for key, value in chosen.items())


def age(seconds: float) -> str:
    """An age in words, '2 d 03 h'; 0 where the clock was put back."""
    seconds = max(0.0, seconds)
    return f"{seconds // 86400:.0f} d {seconds // 3600 % 24:02.0f} h" if seconds >= 86400 else duration(seconds)


def megabytes(size: int) -> str:
    return f"{size / 1e9:.2f} GB" if size >= 1e9 else f"{size / 1e6:.1f} MB"
