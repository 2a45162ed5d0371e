"""Run the jobs of a plan by Hydra, in this process or through a launcher, or show what was composed."""

from __future__ import annotations

import sys

from hydra._internal.hydra import Hydra
from hydra.types import RunMode
from omegaconf import OmegaConf

from curionav_cli.config import search
from curionav_cli.config.compose import Plan
from curionav_cli.config.job import Job, Outcome, Trial, Work
from curionav_cli.config.sources import MAIN
from curionav_cli.errors import ConfigError


def run(hydra: Hydra, plan: Plan, work: Work) -> list[Outcome]:
    """Run the plan and return an outcome for each job; none where a sweeper draws its own values."""
    if not plan.multirun:
        return [hydra.run(MAIN, Job(work), plan.overrides).return_value]
    if plan.engine:
        sign = -1 if plan.engine.package in search.MINIMISES else 1
        search.run(hydra, plan.overrides, plan.folder, plan.engine, Trial(work, sign))
        return []
    batches = hydra.multirun(MAIN, Job(work), plan.overrides)
    return [job.return_value for batch in batches or [] for job in batch]


def show_config(hydra: Hydra, plan: Plan, kind: str, package: str | None, resolve: bool) -> None:
    """Print the composed YAML of each job. kind: job, hydra or all; package: only the part at this key."""
    for job in plan.jobs:
        if package and OmegaConf.select(hydra.compose_config(MAIN, job, RunMode.RUN), package) is None:
            raise ConfigError(f"The settings have no part {package}. --cfg {kind} without -p shows all.")
        if len(plan.jobs) > 1:
            sys.stdout.write("---\n")
        hydra.show_cfg(MAIN, job, kind, package, resolve)


def show_info(hydra: Hydra, plan: Plan, kind: str) -> None:
    """Print where the configuration comes from: Hydra's plugins, search path, defaults list."""
    hydra.show_info(kind, MAIN, plan.jobs[0])
