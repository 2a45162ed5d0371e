"""A run that takes no time, importable by the workers of a launcher."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

from curionav_cli.config.schema import Config
from curionav_cli.errors import RunFailed, UserError
from curionav_cli.storage.run_folder import RunFolder


def work(settings: Config, folder: Path) -> dict[str, Any]:
    """Fails by its seed: 13 unexpectedly, 14 as a run, 15 as a user's mistake, 16 by Ctrl-C, 17 is killed."""
    if settings.seed == 13:
        raise ZeroDivisionError("unlucky")
    if settings.seed == 14:
        raise RunFailed("the disk is full")
    if settings.seed == 15:
        raise UserError("that folder holds another run")
    if settings.seed == 16:
        raise KeyboardInterrupt
    if settings.seed == 17:
        begin(RunFolder(folder))
        os.kill(os.getpid(), signal.SIGKILL)
    (folder / "ran").write_text(f"{settings.agent.name} {settings.seed} {os.getpid()}")
    threads = (os.environ.get(name, "") for name in ("OMP_NUM_THREADS", "OMP_WAIT_POLICY"))
    (folder / "threads").write_text(" ".join(threads))
    return {"seed": settings.seed}


def begin(run: RunFolder) -> None:
    """What is there of a run after a moment."""
    run.write("config.yaml", "seed: 17\n")
    run.write("run.json", "{}")
    run.set_status(state="running", episode=1, episodes=3)
