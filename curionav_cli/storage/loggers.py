"""Metrics for those who watch them in a program; metrics.jsonl is always written, and nothing leaves the machine.

What a logger holds is derived from metrics.jsonl: it is written anew from there whenever a run begins or goes on.
"""

from __future__ import annotations

import math
import shutil
from typing import Any

from curionav_cli.storage.run_folder import RunFolder


class Local:
    """metrics.jsonl is all there is."""

    def __init__(self, run: RunFolder):
        """Knows what `run` has lived through."""

    def add(self, row: dict[str, Any]) -> None:
        """One more row of metrics.jsonl."""

    def close(self) -> None:
        """The run is over."""


class TensorBoard(Local):
    """A folder `tensorboard` in the run's: tensorboard --logdir outputs shows all runs. Needs the extra tensorboard."""

    def __init__(self, run: RunFolder):
        from tensorboard.summary import Writer

        folder = run.path / "tensorboard"
        shutil.rmtree(folder, ignore_errors=True)
        self.writer = Writer(str(folder))
        for row in run.metrics():
            self.add(row)

    def add(self, row: dict[str, Any]) -> None:
        step = int(row.get("steps", row.get("iterations", 0)))
        for name, value in row.items():
            if isinstance(value, int | float) and math.isfinite(value):
                self.writer.add_scalar(name, value, step)
        self.writer.flush()

    def close(self) -> None:
        self.writer.close()


LOGGERS: dict[str, type[Local]] = {"local": Local, "tensorboard": TensorBoard}
