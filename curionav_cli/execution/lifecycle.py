"""Carry out a run from start to end, also after an interruption: shared by explore, train and dock."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import plain_settings, settings_yaml
from curionav_cli.errors import RunFolderError
from curionav_cli.execution import precision
from curionav_cli.execution.interrupts import ended, stoppable
from curionav_cli.execution.progress import say
from curionav_cli.files import read_json
from curionav_cli.live.settings import LINK, Rosbridge
from curionav_cli.records import FloorPlan
from curionav_cli.storage import checkpoint, provenance
from curionav_cli.storage.run_folder import RunFolder

FILES = ("map", "overlay", "floor", "mesh")  # of env; they may move


class Task(Protocol):
    """What a command does in its run folder.

    fixed: the settings that may not change when the run is resumed. unit: what its checkpoints count, key: the name of
    that count in status.json, total: how many are to be done.
    """

    settings: Config
    run: RunFolder
    fixed: dict[str, Any]
    unit: str
    key: str
    total: int

    def agent(self) -> Agent:
        """Build the agent."""

    def create(self, about: dict[str, Any]) -> None:
        """Create the run folder; about: the content of run.json."""

    def verify(self, done: int) -> None:
        """Check that the first `done` units are there and whole. Raises RunFolderError."""

    def tidy(self) -> None:
        """Do what a changed setting asks of a run that is done already."""

    def rewind(self, done: int) -> None:
        """Remove what came after the first `done` units."""

    def work(self, agent: Agent, first: int) -> None:
        """Run from unit `first` to the last."""


def run_task(command: str, task: Task) -> RunFolder:
    """Carry out the task in its folder to the end; one that has begun there is continued.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    run, saved = task.run, None
    with run.locked(), stoppable():
        begun = run.config.is_file()
        run.refuse_without_config()
        if begun:
            checkpoint.refuse_changes(run.path, read_json(run.path / "fixed.json"), task.fixed)
            if finished(task):
                task.tidy()
                say(f"{run.path}: is done already")
                return run
            saved = newest(task)
        agent = task.agent()
        try:
            if begun:
                continue_run(task, agent, saved)
            else:
                about = provenance.about(run.path, command, str(agent.device), task.settings.seed)
                task.create({**about, **precision.about(task.settings), "question": task.settings.question})
            task.work(agent, saved[0] if saved else 0)
            run.set_status(state="done")
        except BaseException as error:
            failure = ended(run, error)
            if failure is error:
                raise
            raise failure from error
    return run


def finished(task: Task) -> bool:
    """Whether nothing is left to do; False where the status cannot be read."""
    try:
        status = task.run.status
    except RunFolderError:
        return False
    return status.get("state") == "done" and status.get(task.key, 0) >= task.total and \
        bool(checkpoint.finished(task.run.checkpoints))


def newest(task: Task) -> tuple[int, Path] | None:
    """The checkpoint to resume from; None where the run ended before its first one. Raises RunFolderError."""
    saved = checkpoint.newest(task.run.checkpoints, task.fixed, task.verify)
    if not saved and len(task.run.metrics()) > 1:
        raise RunFolderError(f"{task.run.checkpoints} holds no whole checkpoint of what was done. "
                             "Restore it from a copy, or start a new run in another folder.")
    return saved


def continue_run(task: Task, agent: Agent, saved: tuple[int, Path] | None) -> None:
    """Rewind the run folder and the agent to the checkpoint, or to the start."""
    done, folder = saved or (0, None)
    about = provenance.resumed(read_json(task.run.path / "run.json"), task.key, done)
    task.rewind(done)
    if folder:
        agent.load(folder)
    say(f"{task.run.path}: goes on after {done} finished {task.unit}{'' if done == 1 else 's'}")
    task.run.write("run.json", json.dumps(about, indent=2))
    task.run.write("config.yaml", settings_yaml(task.settings))  # the run may have been made longer


def fixed_settings(settings: Config, plan: FloorPlan, loop: Sequence[str] = ()) -> dict[str, Any]:
    """The settings that may not change when a run is resumed. Files may move: their content is compared."""
    plain = plain_settings(settings)
    fixed = {key: plain[key] for key in ("env", "agent", "robot", "seed")}
    fixed["env"] = {key: value for key, value in plain["env"].items() if key not in FILES}
    if isinstance(settings.robot, Rosbridge):
        fixed["robot"] = {key: value for key, value in plain["robot"].items() if key not in LINK}
    bound = ("replay_episodes",) if settings.loop.replay_episodes is not None else ()
    fixed["loop"] = {key: plain["loop"][key] for key in (*loop, *bound)}
    fixed["visitable cells (sha256)"] = hashlib.sha256(plan.visitable.tobytes()).hexdigest()
    if settings.env.overlay:
        fixed["overlay (sha256)"] = hashlib.sha256(Path(settings.env.overlay).read_bytes()).hexdigest()
    return fixed
