"""The run or the runs of a sweep that are watched, as the page asks for them."""

from __future__ import annotations

import json
import threading
from collections import Counter
from pathlib import Path

from curionav_cli.config.planned import planned_runs
from curionav_cli.errors import RunFolderError
from curionav_cli.execution.watching.watched_run import WatchedRun
from curionav_cli.results.runs import job_number
from curionav_cli.results.watching.rows import stamp
from curionav_cli.storage.run_folder import RunFolder

SIGNS = ("config.yaml", "status.json", "run.json", ".hydra")  # any of them is in the folder of a run
METRIC = "coverage"


class Watched:
    """A run, or all runs of a sweep, also those that begin later. Raises RunFolderError where there is neither."""

    def __init__(self, path: Path):
        self.path, self.planned = path.resolve(), planned_runs(path)
        self.single = is_run(path) and not (path / "multirun.yaml").is_file()
        self.runs: dict[str, WatchedRun] = {}
        self.lock = threading.Lock()
        self.update()
        if not self.runs and self.planned is None:
            RunFolder.existing(path)

    def update(self) -> None:
        """Find new runs, and read again what changed."""
        folders = [self.path] if self.single else sorted(
            (folder for folder in self.path.iterdir() if is_run(folder)), key=lambda folder: job_number(folder.name))
        self.runs = {folder.name: self.runs.get(folder.name) or WatchedRun(folder) for folder in folders}
        for run in self.runs.values():
            run.update()

    def state(self, metric: str = "") -> bytes:
        """All that the page shows but the pictures, as JSON. metric: of the curves; "": the first that there is."""
        with self.lock:
            self.update()
            runs = list(self.runs.values())
            names = sorted({name for run in runs for name in run.rows.names()}, key=lambda name: (name != METRIC, name))
            metric = metric if metric in names else next(iter(names), METRIC)
            newest = max(runs, key=lambda run: (run.state == "running", stamp(run.folder.metrics_file)), default=None)
            state = {"title": self.path.name, "summary": self.summary(), "metric": metric, "metrics": names,
                     "newest": newest and newest.name, "runs": [run.row(metric) for run in runs]}
        return json.dumps(state).encode()

    def summary(self) -> str:
        """All runs in a line: '6 runs: 2 running, 1 done, 3 waiting'."""
        states: Counter[str] = Counter(run.state for run in self.runs.values())
        count = max(len(self.runs), self.planned or 0)
        states["waiting"] += count - len(self.runs)
        counted = ", ".join(f"{number} {state}" for state, number in states.most_common() if number)
        return f"{count} run{'s' * (count != 1)}: {counted}"

    def picture(self, kind: str, name: str) -> bytes | None:
        """A picture of a run as PNG; None where there is none, or no run of this name."""
        with self.lock:
            run = self.runs.get(name)
            try:
                return run.picture(kind) if run else None
            except RunFolderError:
                return None


def is_run(folder: Path) -> bool:
    return any((folder / sign).exists() for sign in SIGNS)


