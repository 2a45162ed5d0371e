"""A run from its beginning to its end, also after an interruption: what explore and train have in common."""

from __future__ import annotations

import errno
import hashlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import yaml

from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import settings_yaml
from curionav_cli.errors import RunFailed, RunFolderError
from curionav_cli.records import FloorPlan, read_json
from curionav_cli.storage import checkpoint, provenance
from curionav_cli.storage.run_folder import RunFolder


class Undertaking(Protocol):
    """What a command does in its run folder.

    fixed: the settings that a run may not change when it goes on. unit: what its checkpoints count,
    total: how many of them are to be done.
    """

    settings: Config
    run: RunFolder
    fixed: dict[str, Any]
    unit: str
    total: int

    def agent(self) -> Agent:
        """Who learns, or only acts."""

    def create(self, about: dict[str, Any]) -> None:
        """Begin the folder; about: for run.json."""

    def rewind(self, done: int) -> None:
        """Forget what came after the first `done` units."""

    def work(self, agent: Agent, first: int) -> None:
        """From unit `first` to the last."""


def see_through(command: str, task: Undertaking) -> RunFolder:
    """Do the work in its folder to the end; a folder that holds its beginning is continued.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    run, found = task.run, None
    with run.alone():
        begun = run.config.is_file()
        if begun:
            checkpoint.refuse_changes(run.path, read_json(run.path / "fixed.json"), task.fixed)
            found = checkpoint.newest(run.checkpoints, task.fixed)
        if found and found[0] >= task.total and run.status.get("state") == "done":
            return run
        agent = task.agent()
        try:
            if begun:
                go_on(task, agent, found)
            else:
                about = provenance.about(run.path, command, str(agent.device), task.settings.seed)
                task.create({**about, "question": task.settings.question})
            task.work(agent, found[0] if found else 0)
            run.set_status(state="done")
        except BaseException as error:
            failure = ended(run, error)
            if failure is error:
                raise
            raise failure from error
    return run


def go_on(task: Undertaking, agent: Agent, found: tuple[int, Path] | None) -> None:
    """Put the run back to its newest checkpoint."""
    done, folder = found or (0, None)
    task.rewind(done)
    if folder:
        agent.load(folder)
    print(f"{task.run.path}: goes on after {done} finished {task.unit}{'' if done == 1 else 's'}", flush=True)
    task.run.write("config.yaml", settings_yaml(task.settings))  # it may have become longer


def ended(run: RunFolder, error: BaseException) -> BaseException:
    """Note in status.json how the run ended; the error to raise for it."""
    state, line = "failed", f"{type(error).__name__}: {error}"
    if isinstance(error, KeyboardInterrupt):
        state, line = "interrupted", "interrupted by Ctrl-C"
    elif isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        error = RunFailed(f"The disk is full; what was saved in {run.path} is whole. "
                          f"Free some space, then: curionav resume {run.path}")
        line = str(error)
    with suppress(OSError, RunFolderError):  # on a full disk the status stays what it was
        run.set_status(state=state, error=line)
    return error


def rooted(settings: Config) -> Config:
    """Its files by absolute paths: a run is resumed from any folder."""
    def absolute(path: str | None) -> str | None:
        return str(Path(path).expanduser().resolve()) if path else None
    env = replace(settings.env, map=absolute(settings.env.map), overlay=absolute(settings.env.overlay))
    return replace(settings, env=env, data=absolute(settings.data))


def fixed_settings(settings: Config, plan: FloorPlan, loop: Sequence[str] = ()) -> dict[str, Any]:
    """What a run may not change when it goes on. Files may move: what is in them stands for them."""
    plain = yaml.safe_load(settings_yaml(settings))
    fixed = {key: plain[key] for key in ("env", "agent", "robot", "seed")}
    fixed["env"] = {key: value for key, value in plain["env"].items() if key not in ("map", "overlay")}
    fixed["loop"] = {key: plain["loop"][key] for key in loop}
    fixed["visitable cells (sha256)"] = hashlib.sha256(plan.visitable.tobytes()).hexdigest()
    if settings.env.overlay:
        fixed["overlay (sha256)"] = hashlib.sha256(Path(settings.env.overlay).read_bytes()).hexdigest()
    return fixed
