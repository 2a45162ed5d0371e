"""The choice behind agent.precision=auto: made when a run begins, and kept when it is resumed on another machine."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.agents.lbs_dreamer.settings import Precision
from curionav_cli.config.schema import Config
from curionav_cli.execution.progress import say
from curionav_cli.files import read_json

log = logging.getLogger("curionav")
BEGUN = ("config.yaml", "fixed.json")


def with_precision(settings: Config, folder: Path) -> Config:
    """Replace agent.precision=auto by what the run in `folder` began with, or else by what suits this machine.

    Logs the choice, and prints one line where it is the slower one here.
    """
    asked = getattr(settings.agent, "precision", None)
    if asked is None:
        return settings
    best, recorded = build.automatic(settings), recorded_precision(folder)
    settings = build.with_precision(settings, recorded or best)
    taken = settings.agent.precision
    if asked is Precision.auto and not recorded:
        log.info("agent.precision=auto is %s here (%s)", taken.value, speeds())
    if taken is not best and slow(settings):
        say(f"agent.precision={taken.value} is the slow one on this machine ({speeds()}).")
    return settings


def recorded_precision(folder: Path) -> Precision | None:
    """The precision of the run in `folder`; None where none has begun."""
    if not all((folder / name).is_file() for name in BEGUN):
        return None
    name = read_json(folder / "fixed.json").get("agent", {}).get("precision")
    return Precision(name) if name in ("float32", "bfloat16") else None


def slow(settings: Config) -> bool:
    """Whether the other precision is clearly faster on a CPU; nothing is measured on CUDA."""
    from curionav_cli.agents.arithmetic import faster, rates
    from curionav_cli.agents.device import resolve_device

    other = {Precision.float32: Precision.bfloat16, Precision.bfloat16: Precision.float32}
    return resolve_device(settings.device.value).type == "cpu" and faster(rates(), other[settings.agent.precision])


def speeds() -> str:
    """The measured speed of matrix products in each precision, in words."""
    from curionav_cli.agents.arithmetic import rates

    return ", ".join(f"{name} {rate:.3g} GFLOP/s" for name, rate in rates()._asdict().items())


def about(settings: Config) -> dict[str, Any]:
    """The part of run.json about precision: the agent's, and this processor's GFLOP/s in each."""
    taken = getattr(settings.agent, "precision", None)
    if not taken:
        return {}
    from curionav_cli.agents.arithmetic import rates

    return {"precision": taken.value, "gflops": rates()._asdict()}
