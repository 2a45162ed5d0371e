"""Early ends of a run: Ctrl-C, SIGTERM, a closed pipe, a full or locked disk, no memory; each with what to do next."""

from __future__ import annotations

import errno
import shlex
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from curionav_cli.errors import RunFailed, RunFolderError, Terminated, Unread
from curionav_cli.execution.screen import mute
from curionav_cli.storage.run_folder import RunFolder

FULL, LOCKED = (errno.ENOSPC, errno.EDQUOT), (errno.EROFS, errno.EACCES, errno.EPERM)
UNREAD = "stopped, as its output was closed (a closed pipe)"
INTERRUPTED = {
    KeyboardInterrupt: "interrupted by Ctrl-C", Terminated: "stopped by SIGTERM", Unread: UNREAD,
    SystemExit: "stopped by the scheduler, which sends it again",  # submitit's answer to SIGUSR2
}


@contextmanager
def stoppable() -> Iterator[None]:
    """Let SIGTERM raise Terminated, once, unless a launcher handles the signal itself."""
    free = threading.current_thread() is threading.main_thread() and \
        signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    if free:
        signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        if free:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)


def stop(number: int, frame: FrameType | None) -> None:
    """Handle the first SIGTERM: raise Terminated."""
    signal.signal(number, signal.SIG_IGN)  # a second one must not disturb the end of the run
    raise Terminated


def ended(run: RunFolder, error: BaseException) -> BaseException:
    """Record in status.json how the run ended; returns the error to raise for it."""
    kept = f"What was saved in {run.path} is whole."
    if isinstance(error, BrokenPipeError):
        mute()
        error = Unread()
    state, line = "failed", f"{type(error).__name__}: {error}"
    if type(error) in INTERRUPTED:
        state, line = "interrupted", INTERRUPTED[type(error)]
    elif isinstance(error, OSError) and error.errno in FULL:
        error = RunFailed(f"The disk is full. {kept} Free some space, then: "
                          f"curionav resume {shlex.quote(str(run.path))}")
    elif isinstance(error, OSError) and error.errno in LOCKED:
        error = RunFailed(f"{error.filename or run.path} cannot be written ({error.strerror}). {kept} "
                          f"Make it writable, then: curionav resume {shlex.quote(str(run.path))}")
    elif out_of_memory(error):
        error = RunFailed(f"Out of memory ({first_line(error)}). {kept} Lower loop.replay_memory, loop.steps or the "
                          "sizes of the agent, or in a sweep hydra.launcher.n_jobs, then: "
                          f"curionav resume {shlex.quote(str(run.path))}")
    if isinstance(error, RunFailed):
        line = str(error)
    with suppress(OSError, RunFolderError):  # on a full disk the status stays what it was
        run.set_status(state=state, error=line)
    return error


def out_of_memory(error: BaseException) -> bool:
    """Whether memory ran out, of the machine or of a GPU, as Python, numpy, OpenCV and torch report it."""
    names = {kind.__name__ for kind in type(error).__mro__}
    words = ("not enough memory", "can't allocate memory", "Insufficient memory")
    return bool(names & {"MemoryError", "OutOfMemoryError"}) or any(word in str(error) for word in words)


def first_line(error: BaseException) -> str:
    return next(iter(str(error).splitlines()), "") or type(error).__name__
