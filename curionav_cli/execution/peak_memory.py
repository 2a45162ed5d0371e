"""How much memory a run had resident at most, in bytes."""

from __future__ import annotations

import resource
import sys
from pathlib import Path
from typing import NamedTuple

STATUS = Path("/proc/self/status")  # of Linux: getrusage there counts what a process was before its exec, too
UNIT = 1 if sys.platform == "darwin" else 1024  # bytes, of ru_maxrss


class Resident(NamedTuple):
    """Resident memory of this process: now, and the most so far."""

    now: int
    most: int


class PeakMemory:
    """The peak of a run, from here on, in a process that may have carried out others before it."""

    def __init__(self) -> None:
        self.before = resident().most

    def bytes(self) -> int:
        """The process's peak where this run reached it, else what is resident now."""
        now, most = resident()
        return most if most > self.before else now


def resident() -> Resident:
    """Ask the system; where it does not say what is resident now (macOS), the most so far stands for it."""
    lines = dict(line.split(":", 1) for line in STATUS.read_text().splitlines()) if STATUS.exists() else {}
    if "VmHWM" in lines:
        return Resident(*(1024 * int(lines[name].split()[0]) for name in ("VmRSS", "VmHWM")))
    most = UNIT * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return Resident(most, most)
