"""After a sweep: what its runs could not say themselves: they never began, were killed, or still run elsewhere."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from curionav_cli.config.compose import Plan
from curionav_cli.config.job import Outcome
from curionav_cli.errors import RunFailed, RunFolderError
from curionav_cli.results.runs import job_number
from curionav_cli.storage.run_folder import RunFolder

QUEUED = ".submitit"  # where submitit keeps what it sent to a queue: a folder for each array of jobs


def told(folder: Path) -> list[Outcome]:
    """How the runs of a sweep ended, as their folders say: where a sweeper keeps what its jobs returned."""
    outcomes = []
    for file in sorted(folder.glob("*/status.json"), key=lambda file: job_number(file.parent.name)):
        try:
            status = RunFolder(file.parent).status
        except RunFolderError as error:
            status = {"state": "failed", "error": str(error)}
        failed = status.get("state") == "failed"
        outcomes.append(Outcome(file.parent, int(failed), str(status.get("error")) if failed else ""))
    return outcomes


def note_killed(folder: Path, why: str) -> None:
    """Runs that say 'running' and have no process any more."""
    for run in RunFolder.inside(folder):
        try:
            killed = run.status.get("state") == "running" and not run.in_use
        except RunFolderError:
            killed = True
        if killed:
            run.set_status(state="interrupted", error=why)


def not_begun(todo: Plan) -> list[str]:
    """A line for each run of a sweep that left no folder: what is its own among them; a search does not know."""
    if todo.engine:
        return []
    begun = {job_number(run.path.name)[0] for run in RunFolder.inside(todo.folder)} if todo.multirun else {0}
    shared = set.intersection(*map(set, todo.jobs))
    return [f"not begun: {number}: {' '.join(word for word in job if word not in shared) or ' '.join(job)}"
            for number, job in enumerate(todo.jobs) if number not in begun]


def why(error: BaseException, kills: int) -> str:
    """One line for what a launcher raised. kills: what `memory_kills` counted before."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted by Ctrl-C"
    if isinstance(error.__cause__, OSError):  # Hydra cannot open the run's log
        error = error.__cause__
    text = " ".join(str(error).split())
    if isinstance(error, RunFailed):  # of a search: more trials failed than may
        return text
    if type(error).__name__ != "TerminatedWorkerError":
        return f"{type(error).__name__}: {text}"
    if memory_kills() > kills:
        return ("out of memory: Linux killed a process of the sweep. Run fewer side by side (hydra.launcher.n_jobs=1), "
                "or lower loop.replay_memory")
    signals = re.findall(r"SIG[A-Z]+", text) or ["a signal"]
    return f"a process of the sweep was killed ({signals[0]}), and not by Linux for want of memory"


def memory_kills() -> int:
    """How many processes Linux has killed for want of memory since it started; 0 elsewhere."""
    counters = Path("/proc/vmstat")
    lines = counters.read_text().splitlines() if counters.exists() else []
    return sum(int(line.split()[1]) for line in lines if line.startswith("oom_kill "))


def to_go_on(todo: Plan) -> str:
    """What to type, after the queue's own jobs were stopped: they outlive the process that sent them."""
    names = (path.name for path in (todo.folder / QUEUED).glob("*")) if todo.queued else ()
    sent = sorted((name for name in names if name.isdecimal()), key=int)
    where = shlex.quote(str(todo.folder))
    stop = f"The jobs in the queue still run. To stop them: scancel {' '.join(sent)}\n" if sent else ""
    if todo.engine and not todo.engine.resumable:
        return f"{stop}This sweeper cannot go on; its runs can, each by: curionav resume {where}/..."
    return f"{stop}To go on: curionav resume {where}"
