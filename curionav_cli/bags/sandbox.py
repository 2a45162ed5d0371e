"""Bags are read in a process of their own, with bounds on memory, time and files, because they come from anywhere.

A bag may state any size, and what unpacks it believes that. The kernel does not: beyond a bound the process gets no
memory, or ends, and the one who asked gets a line.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from curionav_cli.bags.source import Source
from curionav_cli.errors import BagError

RESULT = "result.json"
PIXELS = 1 << 26  # of an image that OpenCV unpacks


@dataclass(frozen=True)
class Bounds:
    """memory: bytes of address space; seconds: of processor time, for a bag of no size, and a second for each `pace`
    bytes of it, and by the clock `patience` times that; file: bytes of the largest file that is written, as unpacked
    SQLite files are."""

    memory: int = 2 << 30
    seconds: int = 120
    pace: int = 1 << 20
    patience: int = 10
    file: int = 16 << 30


def convert(path: Path, sources: Sequence[Source], out: Path, prefix: str, bounds: Bounds = Bounds()) -> dict[str, Any]:
    """Write the episodes of a bag into `out` as prefix_000000.npz ...; returns the report. Raises BagError."""
    seconds = bounds.seconds + size(path) // bounds.pace
    asked = {"path": str(path), "out": str(out), "prefix": prefix, "sources": [asdict(source) for source in sources],
             "limits": {"RLIMIT_AS": bounds.memory, "RLIMIT_CPU": seconds, "RLIMIT_FSIZE": bounds.file}}
    environment = {**os.environ, "TMPDIR": str(out), "OMP_NUM_THREADS": "1", "OPENCV_IO_MAX_IMAGE_PIXELS": str(PIXELS)}
    command = [sys.executable, "-P", "-m", "curionav_cli.bags.sandbox"]
    try:
        ended = subprocess.run(command, input=json.dumps(asked), text=True, capture_output=True, env=environment,
                               timeout=seconds * bounds.patience)
    except subprocess.TimeoutExpired as error:
        raise BagError(f"{path} cannot be read as a bag: it took more than {error.timeout:.0f} s.") from error
    result = out / RESULT
    if ended.returncode or not result.is_file():
        raise BagError(f"{path} cannot be read as a bag: {cause(ended.returncode, ended.stderr, seconds)}.")
    report = json.loads(result.read_text())
    result.unlink()
    if "error" in report:
        raise BagError(report["error"])
    return report


def size(path: Path) -> int:
    """Bytes of a bag."""
    return sum(file.stat().st_size for file in (path.iterdir() if path.is_dir() else [path]) if file.is_file())


def cause(code: int, words: str, seconds: int) -> str:
    """Why the process ended without a result."""
    if code in (-signal.SIGXCPU, -signal.SIGKILL):
        return f"it took more than {seconds} s of processor time, or all memory"
    if code < 0:
        return f"reading it ended by {signal.Signals(-code).name}; it is broken"
    return (words.strip().splitlines() or ["reading it ended without a word"])[-1][:200]


def main() -> None:
    """Read one bag, as standard input says."""
    asked = json.load(sys.stdin)
    for name, most in asked["limits"].items():
        kind = getattr(resource, name)
        resource.setrlimit(kind, (most, resource.getrlimit(kind)[1]))
    out = Path(asked["out"])
    try:
        report = converted(asked, out)
    except BagError as error:
        report = {"error": str(error)}
    except MemoryError:
        most = asked["limits"]["RLIMIT_AS"] / 2**30
        report = {"error": f"{asked['path']} cannot be read as a bag: a part of it needs more than {most:.1f} GB of "
                           "memory to be unpacked."}
    (out / RESULT).write_text(json.dumps(report))


def converted(asked: dict[str, Any], out: Path) -> dict[str, Any]:
    """Write the episodes; returns the report."""
    from curionav_cli.bags.intake import episodes

    report: dict[str, Any] = {}
    sources = [Source(**source) for source in asked["sources"]]
    for number, episode in enumerate(episodes(Path(asked["path"]), sources, report)):
        episode.save(out / f"{asked['prefix']}_{number:06d}.npz")
        report["episodes"] = number + 1
    return report


if __name__ == "__main__":
    main()
