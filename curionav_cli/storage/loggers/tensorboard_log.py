"""logger=tensorboard: events in the run's folder `tensorboard`; tensorboard --logdir outputs shows all runs.

Needs the extra tensorboard. Nothing leaves the machine.
"""

from __future__ import annotations

import math
import shutil
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from curionav_cli.storage.loggers.logger import Local, step_of
from curionav_cli.storage.run_folder import RunFolder


class TensorBoard(Local):
    """The finite numbers of every row at its step, and the figures as images."""

    def __init__(self, run: RunFolder):
        from tensorboard.summary import Writer

        self.folder, self.step = run.path / "tensorboard", 0
        shutil.rmtree(self.folder, ignore_errors=True)
        self.writer = Writer(str(self.folder))
        for row in run.metrics():
            self.add(row)

    def add(self, row: dict[str, Any]) -> None:
        self.step = step_of(row)
        for name, value in row.items():
            if isinstance(value, int | float) and math.isfinite(value):
                self.writer.add_scalar(name, value, self.step)
        self.writer.flush()

    def add_figures(self, figures: Sequence[Path]) -> None:
        from tensorboard.compat.proto.event_pb2 import Event
        from tensorboard.compat.proto.summary_pb2 import Summary
        from tensorboard.summary.writer.event_file_writer import EventFileWriter

        events = EventFileWriter(str(self.folder), filename_suffix=".figures")
        for path in figures:
            image = Summary.Image(encoded_image_string=path.read_bytes(), colorspace=4)
            value = Summary.Value(tag=f"figures/{path.stem}", image=image)
            events.add_event(Event(wall_time=time.time(), step=self.step, summary=Summary(value=[value])))
        events.close()

    def close(self) -> None:
        self.writer.close()
