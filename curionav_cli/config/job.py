"""A task as Hydra's launchers call it, in this process or another: settings in, an outcome out.

It never raises, so that one failed job does not end a sweep; its traceback is in the job's own log.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from hydra.core.hydra_config import HydraConfig
from omegaconf import DictConfig

from curionav_cli.config.schema import Config
from curionav_cli.config.settings import as_settings
from curionav_cli.errors import RunFailed, UserError

Work = Callable[[Config, Path], dict[str, Any]]


@dataclass(frozen=True)
class Outcome:
    """How one job ended. code: the exit code it deserves (0, 1 or 2); error: one line, empty if done."""

    folder: Path
    code: int = 0
    error: str = ""
    result: dict[str, Any] = field(default_factory=dict)

    def __float__(self) -> float:
        """What a sweeper that searches maximises: the run's coverage; nan for a failed run."""
        return float(self.result.get("coverage", "nan"))


@dataclass(frozen=True)
class Job:
    """`work` is a function at the top of a module (or a partial of one), since launchers pickle it."""

    work: Work

    def __call__(self, config: DictConfig) -> Outcome:
        runtime = HydraConfig.get().runtime
        folder = Path(runtime.output_dir)
        log = logging.getLogger("curionav")
        try:
            return Outcome(folder, result=self.work(as_settings(config, Path(runtime.cwd)), folder))
        except (UserError, RunFailed) as error:
            log.exception("the run could not go on")
            return Outcome(folder, 2 if isinstance(error, UserError) else 1, str(error))
        except Exception as error:
            log.exception("the run failed")
            return Outcome(folder, 1, f"{type(error).__name__}: {error}")
