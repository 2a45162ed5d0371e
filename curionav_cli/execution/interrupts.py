"""How a run ends before its time: Ctrl-C, SIGTERM, a full or locked disk, no memory; in words that say what to do."""

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
UNREAD = "stopped, as nobody read its output any more (a closed pipe)"
INTERRUPTED = {
    KeyboardInterrupt: "interrupted by Ctrl-C", Terminated: "stopped by SIGTERM", Unread: UNREAD,
    SystemExit: "stopped by the scheduler, which sends it again",  # submitit's answer to SIGUSR2
}


@contextmanager
def stoppable() -> Iterator[None]:
    """SIGTERM raises Terminated in here, once, unless a launcher has an answer of its own."""
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
    signal.signal(number, signal.SIG_IGN)  # what ends is not disturbed by a second one
    raise Terminated


def ended(run: RunFolder, error: BaseException) -> BaseException:
    """Note in status.json how the run ended; the error to raise for it."""
    on = f"What was saved in {run.path} is whole."
    if isinstance(error, BrokenPipeError):
        mute()
        error = Unread()
    state, line = "failed", f"{type(error).__name__}: {error}"
    if type(error) in INTERRUPTED:
        state, line = "interrupted", INTERRUPTED[type(error)]
    elif isinstance(error, OSError) and error.errno in FULL:
        error = RunFailed(f"The disk is full. {on} Free some space, then: "
                          f"curionav resume {shlex.quote(str(run.path))}")
    elif isinstance(error, OSError) and error.errno in LOCKED:
        error = RunFailed(f"{error.filename or run.path} cannot be written ({error.strerror}). {on}")
    elif out_of_memory(error):
        error = RunFailed(f"Out of memory ({first_line(error)}). {on} Lower loop.replay_memory, loop.steps or the "
                          "sizes of the agent, or in a sweep hydra.launcher.n_jobs, then: "
                          f"curionav resume {shlex.quote(str(run.path))}")
    if isinstance(error, RunFailed):
        line = str(error)
    with suppress(OSError, RunFolderError):  # on a full disk the status stays what it was
        run.set_status(state=state, error=line)
    return error


def out_of_memory(error: BaseException) -> bool:
    """Python's, numpy's, OpenCV's and torch's ways to say so, of the machine's memory and of a GPU's."""
    names = {kind.__name__ for kind in type(error).__mro__}
    words = ("not enough memory", "can't allocate memory", "Insufficient memory")
    return bool(names & {"MemoryError", "OutOfMemoryError"}) or any(word in str(error) for word in words)


def first_line(error: BaseException) -> str:
    return next(iter(str(error).splitlines()), "") or type(error).__name__
