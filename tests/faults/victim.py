"""Runs commands in forks of a warm process, and kills them at a counted moment, as a power cut would.

A moment is the n-th event that Python's profiler sees in one phase of a run: a call, a return, or a call into C
such as a write or a rename. In the phase "writing" the n-th place in the program that writes to the disk finds it
full, once. Lines of JSON in: words, phase, at, files; lines of JSON out: code, and events by phase.
"""

from __future__ import annotations

import errno
import json
import os
import signal
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import curionav_cli.results.prediction.figures  # noqa: F401  (warm: what a run imports late)
from curionav_cli import app, loop
from curionav_cli.agents.lbs_dreamer.agent import LBSDreamer
from curionav_cli.commands import explore
from curionav_cli.execution import exploration
from curionav_cli.execution.recorder import Recorder
from curionav_cli.results import plots, tables  # noqa: F401
from curionav_cli.storage.run_folder import RunFolder

PHASES: dict[str, list[tuple[Any, str]]] = {
    "beginning": [(RunFolder, "create")],
    "acting": [(loop, "run_episode")],
    "training": [(LBSDreamer, "learn"), (LBSDreamer, "predict")],
    "saving": [(Recorder, "keep"), (RunFolder, "save_episode"), (RunFolder, "save_prediction")],
    "drawing": [(exploration, "draw")],
    "writing": [(explore, "work")],
}
WRITES = {"write", "writelines", "pwrite", "fsync", "mkdir", "rename", "replace", "truncate"}
os_in_c = sys.modules["posix"]
seen: Counter[str] = Counter()
places: set[tuple[str, ...]] = set()


def counted(phase: str, at: int | None, plain: Callable) -> Callable:
    """`plain`, its events counted; the process dies at the `at`-th of the phase."""
    def event(frame: FrameType, kind: str, called: Any) -> None:
        if phase == "writing" and not (kind == "c_call" and new_place(frame, called)):
            return
        seen[phase] += 1
        if seen[phase] == at and phase == "writing":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        if seen[phase] == at:
            os.kill(os.getpid(), signal.SIGKILL)

    def wrapped(*args: Any, **kwargs: Any) -> Any:
        sys.setprofile(event)
        try:
            return plain(*args, **kwargs)
        finally:
            sys.setprofile(None)
    return wrapped


def new_place(frame: FrameType | None, called: Any) -> bool:
    """Whether this call into C writes to the disk, and none from the same functions of ours did before."""
    file = getattr(called, "__self__", None)
    if called.__name__ not in WRITES or not (file is os_in_c or isinstance(getattr(file, "name", None), str | Path)):
        return False
    if file in (sys.stdout, sys.stderr):
        return False
    way = [called.__name__]
    while frame is not None:
        if "curionav_cli" in frame.f_code.co_filename:
            way.append(frame.f_code.co_qualname)
        frame = frame.f_back
    fresh = tuple(way) not in places
    places.add(tuple(way))
    return fresh


def child(order: dict[str, Any]) -> int:
    """The exit code of one command."""
    for number, path in enumerate(order["files"], 1):
        os.dup2(os.open(path, os.O_CREAT | os.O_WRONLY | os.O_TRUNC), number)
    for phase, places in PHASES.items():
        if order["phase"] in (phase, "all"):
            for owner, name in places:
                setattr(owner, name, counted(phase, order["at"], getattr(owner, name)))
    try:
        app.main(order["words"])
    except SystemExit as stop:
        code = int(stop.code or 0)
    sys.stdout.flush()
    sys.stderr.flush()
    return code


def serve() -> None:
    for line in sys.stdin:
        order = json.loads(line)
        reader, writer = os.pipe()
        pid = os.fork()
        if not pid:
            os.close(reader)
            code = child(order)
            os.write(writer, json.dumps(seen).encode())
            os._exit(code)
        os.close(writer)
        with open(reader) as pipe:
            events = pipe.read()
        code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        print(json.dumps({"code": code, "events": json.loads(events or "{}")}), flush=True)


if __name__ == "__main__":
    serve()
