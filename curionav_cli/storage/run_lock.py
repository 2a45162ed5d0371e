"""The lock of a run folder: one process at a time may write into it."""

from __future__ import annotations

import fcntl
import os
import platform
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from curionav_cli.errors import RunFolderError

PATIENCE = 0.5  # seconds: a process that only asks holds the lock for a moment


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Make the folder and keep every other process out. Raises RunFolderError where one is in already."""
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / ".lock", "a+") as file:
        if not acquired(file, PATIENCE):
            raise already_in_use(folder)
        file.truncate(0)
        file.write(f"process {os.getpid()} on {platform.node()}")
        file.flush()
        yield


def is_locked(folder: Path) -> bool:
    """Whether a process holds the lock now."""
    try:
        with open(folder / ".lock") as file:
            return not acquired(file)
    except FileNotFoundError:
        return False


def already_in_use(folder: Path) -> RunFolderError:
    """The error that names the process which holds the lock."""
    holder = (folder / ".lock").read_text().strip() or "another process"
    return RunFolderError(f"{folder} is in use by {holder}. Wait for it, or stop it.")


def acquired(file: IO[str], patience: float = 0.0) -> bool:
    """Take the lock on an open file until it is closed; False where it is not free within `patience` seconds."""
    until = time.monotonic() + patience
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return True
        except BlockingIOError:
            if time.monotonic() >= until:
                return False
            time.sleep(0.05)
