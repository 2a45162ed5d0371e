"""Loggers: metrics in the form that another program shows, beside metrics.jsonl, which is always written.

What a logger holds is derived from metrics.jsonl and written anew from there whenever a run begins or is resumed.
Nothing leaves the machine.
"""

from __future__ import annotations

import math
import shutil
from typing import Any

from curionav_cli.storage.run_folder import RunFolder


class Local:
    """The logger that adds nothing to metrics.jsonl; the base class of others."""

    def __init__(self, run: RunFolder):
        """Begin with the rows that metrics.jsonl of `run` holds already."""

    def add(self, row: dict[str, Any]) -> None:
        """Log one more row of metrics.jsonl: the finite numbers in it, at its step or iteration."""

    def close(self) -> None:
        """End the log, when the run ends."""


class TensorBoard(Local):
    """TensorBoard events in the run's folder `tensorboard`; tensorboard --logdir outputs shows all runs.

    Needs the extra tensorboard.
    """

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
