"""After a sweep: runs that never started, were killed, or still run elsewhere, which could not report it themselves."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from curionav_cli.config.compose import Plan
from curionav_cli.config.job import Outcome
from curionav_cli.errors import RunFailed, RunFolderError
from curionav_cli.results.runs import job_number
from curionav_cli.storage.run_folder import RunFolder

QUEUED = ".submitit"  # submitit's folder, with one folder for each array of jobs in the queue


def recorded_outcomes(folder: Path) -> list[Outcome]:
    """The outcomes of a sweep's runs from their folders, for a sweeper that does not return them."""
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
    """Set the state of runs that are recorded as running and have no process any more."""
    for run in RunFolder.inside(folder):
        try:
            killed = run.status.get("state") == "running" and not run.in_use
        except RunFolderError:
            killed = True
        if killed:
            run.set_status(state="interrupted", error=why)


def not_started(todo: Plan) -> list[str]:
    """A line for each run of a sweep that has no folder, with the settings that are its own; [] for a search."""
    if todo.engine:
        return []
    begun = {job_number(run.path.name)[0] for run in RunFolder.inside(todo.folder)} if todo.multirun else {0}
    shared = set.intersection(*map(set, todo.jobs))
    return [f"not started: {number}: {' '.join(word for word in job if word not in shared) or ' '.join(job)}"
            for number, job in enumerate(todo.jobs) if number not in begun]


def why(error: BaseException, kills: int) -> str:
    """One line for an error of a launcher. kills: what `memory_kills` counted before the sweep."""
    if isinstance(error, KeyboardInterrupt):
        return "interrupted by Ctrl-C"
    if isinstance(error.__cause__, OSError):  # Hydra cannot open the run's log
        error = error.__cause__
    text = " ".join(str(error).split())
    if isinstance(error, RunFailed):  # of a search: too many trials failed
        return text
    if type(error).__name__ != "TerminatedWorkerError":
        return f"{type(error).__name__}: {text}"
    if memory_kills() > kills:
        return ("out of memory: Linux killed a process of the sweep. Run fewer side by side (hydra.launcher.n_jobs=1), "
                "or lower loop.replay_memory")
    signals = re.findall(r"SIG[A-Z]+", text) or ["a signal"]
    return f"a process of the sweep was killed ({signals[0]}), and not by Linux for lack of memory"


def memory_kills() -> int:
    """How many processes Linux has killed for lack of memory since it started; 0 on other systems."""
    counters = Path("/proc/vmstat")
    lines = counters.read_text().splitlines() if counters.exists() else []
    return sum(int(line.split()[1]) for line in lines if line.startswith("oom_kill "))


def how_to_continue(todo: Plan) -> str:
    """What to type to continue, and to stop the jobs in a queue, which go on without the process that sent them."""
    names = (path.name for path in (todo.folder / QUEUED).glob("*")) if todo.queued else ()
    sent = sorted((name for name in names if name.isdecimal()), key=int)
    where = shlex.quote(str(todo.folder))
    stop = f"The jobs in the queue still run. To stop them: scancel {' '.join(sent)}\n" if sent else ""
    if todo.engine and not todo.engine.resumable:
        return f"{stop}This sweeper cannot be resumed; its runs can, each by: curionav resume {where}/..."
    return f"{stop}To go on: curionav resume {where}"
