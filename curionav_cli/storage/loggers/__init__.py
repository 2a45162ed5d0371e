"""Loggers by name, and several of them at once."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from curionav_cli.errors import SoundnessWarning
from curionav_cli.storage.loggers.logger import Local
from curionav_cli.storage.loggers.tensorboard_log import TensorBoard
from curionav_cli.storage.loggers.trackio_log import Trackio
from curionav_cli.storage.loggers.wandb_log import WandB
from curionav_cli.storage.run_folder import RunFolder

LOGGERS: dict[str, type[Local]] = {"local": Local, "tensorboard": TensorBoard, "wandb": WandB, "trackio": Trackio}
CONSTRAINTS = {"trackio": "constraints-trackio.txt"}  # with another pillow than constraints.txt


def missing(names: Sequence[str]) -> str:
    """What to do about the first logger whose package is not installed, in a line; "" where all are.

    A logger, its package and its extra have one name.
    """
    for name in names:
        if name != "local" and find_spec(name) is None:
            return (f"logger={name} needs {name}, which is not installed. Set logger=local, or: .venv/bin/pip install "
                    f"-c {CONSTRAINTS.get(name, 'constraints.txt')} -e '.[{name}]'")
    return ""


class Loggers(Local):
    """Several loggers. One that fails says so, once, and is left out from then on; the run goes on."""

    def __init__(self, run: RunFolder, names: Sequence[str]):
        self.run, self.open = run, dict.fromkeys(names, Local(run))
        for name in names:
            self.attempt(name, partial(self.begin, name))

    def begin(self, name: str) -> None:
        self.open[name] = LOGGERS[name](self.run)

    def add(self, row: dict[str, Any]) -> None:
        for name, logger in [*self.open.items()]:
            self.attempt(name, partial(logger.add, row))

    def add_figures(self, figures: Sequence[Path]) -> None:
        for name, logger in [*self.open.items()] if figures else []:
            self.attempt(name, partial(logger.add_figures, figures))

    def close(self) -> None:
        for name, logger in [*self.open.items()]:
            self.attempt(name, logger.close)

    def attempt(self, name: str, act: Callable[[], object]) -> None:
        """Let a logger do something; where it fails, say so and use it no more."""
        try:
            act()
        except Exception as error:
            del self.open[name]
            text = (f"logger={name} failed and logs no more of {self.run.path} ({type(error).__name__}: {error}). "
                    f"The run goes on, and {self.run.metrics_file.name} has every row.")
            logging.getLogger("curionav").warning(text, exc_info=error)
            warnings.warn(text, SoundnessWarning, stacklevel=2)
