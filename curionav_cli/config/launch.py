"""Hydra runs the jobs of a plan, in this process or through a launcher, or shows what it composed."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from hydra._internal.hydra import Hydra
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from curionav_cli.config.preflight import Plan
from curionav_cli.config.sources import MAIN
from curionav_cli.errors import ConfigError

Task = Callable[[DictConfig], Any]


def run(hydra: Hydra, plan: Plan, task: Task) -> list[Any]:
    """What `task` returned for each job; a sweeper that draws its own values returns nothing."""
    if not plan.multirun:
        return [hydra.run(MAIN, task, plan.overrides).return_value]
    batches = hydra.multirun(MAIN, task, plan.overrides)
    return [job.return_value for batch in batches or [] for job in batch]


def show_config(hydra: Hydra, plan: Plan, kind: str, package: str | None, resolve: bool) -> None:
    """The composed YAML of each job; kind: job, hydra or all; package: only the part at this key."""
    for job in plan.jobs:
        config = hydra.compose_config(MAIN, job, RunMode.RUN)
        if package and OmegaConf.select(config, package) is None:
            raise ConfigError(f"The settings have no part {package}. --cfg {kind} without -p shows all.")
        if len(plan.jobs) > 1:
            sys.stdout.write("---\n")
        hydra.show_cfg(MAIN, job, kind, package, resolve)


def show_info(hydra: Hydra, plan: Plan, kind: str) -> None:
    """How the configuration came about: Hydra's plugins, search path, defaults list."""
    hydra.show_info(kind, MAIN, plan.jobs[0])
