"""What agent.precision=auto is in a run: chosen when it begins, and kept when it goes on elsewhere."""

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


def settled(settings: Config, folder: Path) -> Config:
    """agent.precision=auto becomes what the run in `folder` began with, or what is right for this machine.

    Tells of the choice in the log, and in one line of a choice that is the slow one here.
    """
    asked = getattr(settings.agent, "precision", None)
    if asked is None:
        return settings
    right, begun = build.automatic(settings), begun_with(folder)
    settings = build.with_precision(settings, begun or right)
    taken = settings.agent.precision
    if asked is Precision.auto and not begun:
        log.info("agent.precision=auto is %s here (%s)", taken.value, speeds())
    if taken is not right and slow(settings):
        say(f"agent.precision={taken.value} is the slow one on this machine ({speeds()}).")
    return settings


def begun_with(folder: Path) -> Precision | None:
    """The precision of the run in `folder`, if one has begun there."""
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
    from curionav_cli.agents.arithmetic import rates

    return ", ".join(f"{name} {rate:.3g} GFLOP/s" for name, rate in rates()._asdict().items())


def about(settings: Config) -> dict[str, Any]:
    """For run.json: the precision of who learns, and how fast this machine's processor multiplies in both."""
    taken = getattr(settings.agent, "precision", None)
    if not taken:
        return {}
    from curionav_cli.agents.arithmetic import rates

    return {"precision": taken.value, "gflops": rates()._asdict()}
