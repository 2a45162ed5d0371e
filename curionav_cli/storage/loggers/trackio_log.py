"""logger=trackio: one SQLite file in the folder `trackio` beside the runs; no account, no server.

Needs the extra trackio. The runs of a sweep, or of a date, are one project: TRACKIO_DIR=outputs/DATE/trackio trackio
show. Rows are written by trackio's own storage and not by trackio.log, whose queue is lost when a run is killed.
"""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from curionav_cli.storage.loggers.logger import Local, identity, settings_of, step_of, sweep_of
from curionav_cli.storage.run_folder import RunFolder


class Trackio(Local):
    """The rows of metrics.jsonl at their steps, in a run whose name and id stay the same."""

    def __init__(self, run: RunFolder):
        folder = run.path.resolve().parent
        keep_in(folder / "trackio")
        from trackio.sqlite_storage import SQLiteStorage

        self.storage, self.project, self.step = SQLiteStorage, folder.name or "curionav", 0
        self.name, self.id = run.path.resolve().name, identity(run)
        self.config = {**settings_of(run), "_Group": sweep_of(run)}
        self.storage.delete_run(self.project, self.name, self.id)
        shutil.rmtree(folder / "trackio" / "media" / self.project / self.name, ignore_errors=True)
        self.write(run.metrics())

    def write(self, rows: Sequence[dict[str, Any]]) -> None:
        """Write rows, and with them the settings."""
        if rows:
            steps = [step_of(row) for row in rows]
            self.step = steps[-1]
            self.storage.bulk_log(self.project, self.name, list(rows), steps, config=self.config, run_id=self.id)

    def add(self, row: dict[str, Any]) -> None:
        self.write([row])

    def add_figures(self, figures: Sequence[Path]) -> None:
        from trackio import Image

        shown = {}
        for path in figures:
            image = Image(str(path), caption=path.stem)
            image._save(self.project, self.name, self.step)
            shown[f"figures/{path.stem}"] = image._to_dict()
        self.storage.bulk_log(self.project, self.name, [shown], [self.step], run_id=self.id)


def keep_in(folder: Path) -> None:
    """Let trackio keep its files in `folder`; it reads where at its import, so one that is loaded is set too."""
    os.environ["TRACKIO_DIR"] = str(folder)
    folder.mkdir(parents=True, exist_ok=True)
    import trackio.sqlite_storage
    import trackio.table  # noqa: F401  (with it every module that keeps a folder is loaded)

    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] == "trackio":
            for key, value in (("TRACKIO_DIR", folder), ("MEDIA_DIR", folder / "media")):
                if hasattr(module, key):
                    setattr(module, key, value)
