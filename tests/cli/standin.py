"""A run that takes no time, importable by the workers of a launcher."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from curionav_cli.config.schema import Config
from curionav_cli.errors import RunFailed, UserError


def live(settings: Config, folder: Path) -> dict[str, Any]:
    """Fails by its seed: 13 unexpectedly, 14 as a run, 15 as a user's mistake, 16 by Ctrl-C."""
    if settings.seed == 13:
        raise ZeroDivisionError("unlucky")
    if settings.seed == 14:
        raise RunFailed("the disk is full")
    if settings.seed == 15:
        raise UserError("that folder holds another run")
    if settings.seed == 16:
        raise KeyboardInterrupt
    (folder / "lived").write_text(f"{settings.agent.name} {settings.seed} {os.getpid()}")
    return {"seed": settings.seed}
