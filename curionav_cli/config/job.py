"""A task as Hydra's launchers call it, in this process or another: settings in, an outcome out.

It does not raise, so that one failed job does not end a sweep; the traceback is in the job's own log. A sweeper that
draws its own values gets a number instead, or an exception where the run failed.
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

OBJECTIVE = "coverage"  # in what `work` returns: what a search maximises
Work = Callable[[Config, Path], dict[str, Any]]


@dataclass(frozen=True)
class Outcome:
    """How one job ended. code: its exit code (0, 1 or 2); error: one line, empty if done."""

    folder: Path
    code: int = 0
    error: str = ""
    result: dict[str, Any] = field(default_factory=dict)


def reason(error: Exception) -> str:
    """One line for an error; an unexpected one with its type."""
    return str(error) if isinstance(error, UserError | RunFailed) else f"{type(error).__name__}: {error}"


@dataclass(frozen=True)
class Job:
    """A task for Hydra. work: a function at the top of a module, or a partial of one, as launchers pickle it."""

    work: Work

    def __call__(self, config: DictConfig) -> Any:
        """Run the job and return its Outcome."""
        return self.outcome(config)

    def outcome(self, config: DictConfig) -> Outcome:
        """Run the job; an error becomes its Outcome."""
        runtime = HydraConfig.get().runtime
        folder = Path(runtime.output_dir)
        log = logging.getLogger("curionav")
        try:
            return Outcome(folder, result=self.work(as_settings(config, Path(runtime.cwd)), folder))
        except (UserError, RunFailed) as error:
            log.exception("the run could not go on")
            return Outcome(folder, 2 if isinstance(error, UserError) else 1, reason(error))
        except Exception as error:
            log.exception("the run failed")
            return Outcome(folder, 1, reason(error))


@dataclass(frozen=True)
class Trial(Job):
    """A job of a sweeper that draws its own values. sign: -1 where the sweeper only minimises."""

    sign: int = 1

    def __call__(self, config: DictConfig) -> float:
        """Run the job and return its objective, 0 where it has none. Raises RunFailed where the run failed."""
        outcome = self.outcome(config)
        if outcome.code:
            raise RunFailed(f"{outcome.folder.name}: {outcome.error}")
        return self.sign * float(outcome.result.get(OBJECTIVE, 0))
