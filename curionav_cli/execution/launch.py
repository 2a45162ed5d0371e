"""Carry out a command with settings: check every job, then show the settings, run or sweep."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from curionav_cli.config import hydra_run as hydra_launch
from curionav_cli.config.compose import Check, Plan, plan
from curionav_cli.config.job import Outcome, Work, reason
from curionav_cli.config.schema import Config
from curionav_cli.config.sources import Hydra, opened
from curionav_cli.errors import ConfigError, RunFailed, RunFolderError, Terminated, Unread, UserError
from curionav_cli.execution import sweep_failures
from curionav_cli.execution.interrupts import UNREAD, stoppable
from curionav_cli.execution.sweep_monitor import monitored
from curionav_cli.storage.run_folder import RunFolder

INTERRUPTED = 130

Summary = Callable[[Path, list[Outcome]], None]


@dataclass(frozen=True)
class Request:
    """One command line. cfg: job, hydra or all; info: one of Hydra's kinds; without either it runs.

    skip_failed: a run that has failed before is not run again.
    """

    command: str
    overrides: list[str]
    multirun: bool = False
    cfg: str | None = None
    package: str | None = None
    resolve: bool = False
    info: str | None = None
    config_dirs: tuple[Path, ...] = ()
    skip_failed: bool = False


@dataclass(frozen=True)
class RecordFailure:
    """Do `work`; a run that fails before it has a status.json gets one, so that its folder holds the reason."""

    work: Work

    def __call__(self, settings: Config, folder: Path) -> dict[str, Any]:
        try:
            return self.work(settings, folder)
        except Exception as error:
            if folder.is_dir() and not (folder / "status.json").exists():
                with suppress(OSError):  # a full disk leaves it without one
                    RunFolder(folder).set_status(state="failed", error=reason(error))
            raise


@dataclass(frozen=True)
class SkipFailed:
    """Do `work`, except for runs that have failed before."""

    work: Work

    def __call__(self, settings: Config, folder: Path) -> dict[str, Any]:
        if state(RunFolder(folder)) == "failed":
            raise RunFailed(f"failed before. To run it again: curionav resume {folder.parent} --failed")
        return self.work(settings, folder)


def state(run: RunFolder) -> str:
    """The state in status.json; "broken" where it cannot be read. Resuming writes it again."""
    try:
        return run.state
    except RunFolderError:
        return "broken"


def launch(request: Request, work: Work, summary: Summary, check: Check | None = None, objective: str = "") -> int:
    """Carry out a command; returns the exit code. Raises UserError for wrong settings before anything runs.

    work(settings, folder): does one run in its folder; returns what its row of the table needs.
    check(settings): raises UserError for what the schema cannot check; called for each job before the first one runs.
    summary(folder, outcomes): prints the last lines; called after failures and interruptions too.
    objective: what work's "coverage" is, in words; a command without it cannot be searched.
    """
    shows = request.cfg or request.info
    with opened(request.command, *request.config_dirs) as hydra, stoppable():
        todo = plan(hydra, request.overrides, request.multirun, None if shows else check)
        if request.info:
            hydra_launch.show_info(hydra, todo, request.info)
        elif request.cfg:
            hydra_launch.show_config(hydra, todo, request.cfg, request.package, request.resolve)
        if shows:
            return 0
        if todo.engine and todo.engine.searches and not objective:
            raise ConfigError(f"curionav {request.command} has no objective to search by. "
                              "Search with curionav explore, or sweep without hydra/sweeper.")
        if not todo.multirun:
            RunFolder(todo.folder).refuse_if_in_use()  # before Hydra writes there
        with RunFolder(todo.folder).locked() if todo.engine else nullcontext():
            work = RecordFailure(SkipFailed(work) if request.skip_failed else work)
            return run_plan(hydra, todo, request, work, summary, objective)


def run_plan(hydra: Hydra, todo: Plan, request: Request, work: Work, summary: Summary, objective: str) -> int:
    """Run the plan to its end, or to an interruption, and print the summary; returns the exit code."""
    outcomes, broken, kills = [], None, sweep_failures.memory_kills()
    if todo.engine and todo.engine.searches:
        print(todo.engine.about(objective), flush=True)
    try:
        with monitored(todo):
            outcomes = hydra_launch.run(hydra, todo, work)
    except Terminated:
        raise Terminated(f"Stopped by SIGTERM. {sweep_failures.how_to_continue(todo)}") from None
    except Unread:
        sweep_failures.note_killed(todo.folder, UNREAD)
        raise
    except UserError:
        raise
    except (Exception, KeyboardInterrupt) as error:  # jobs report their own errors: this is the launcher, or the folder
        broken = error
        sweep_failures.note_killed(todo.folder, sweep_failures.why(error, kills))
    if todo.engine:
        outcomes = sweep_failures.recorded_outcomes(todo.folder)
    summary(todo.folder, outcomes)
    for line in sweep_failures.not_started(todo) if broken else ():
        print(line)
    if isinstance(broken, KeyboardInterrupt):
        print(f"Interrupted. {sweep_failures.how_to_continue(todo)}", file=sys.stderr)
        return INTERRUPTED
    if broken:
        report(request, outcomes, swept=True)
        raise RunFailed(f"{todo.folder} could not be run: {sweep_failures.why(broken, kills)}. "
                        f"{sweep_failures.how_to_continue(todo)}") from broken
    return report(request, outcomes, swept=todo.multirun)


def report(request: Request, outcomes: list[Outcome], swept: bool) -> int:
    """Print each failure in one line, and where its traceback is; returns the exit code."""
    failed = [outcome for outcome in outcomes if outcome.code]
    for outcome in failed:
        print(f"{outcome.folder.name}: {outcome.error}" if swept else outcome.error, file=sys.stderr)
        if outcome.code == 1:
            print(f"The traceback is in {outcome.folder / request.command}.log", file=sys.stderr)
    if swept:
        return 1 if failed else 0
    return failed[0].code if failed else 0
