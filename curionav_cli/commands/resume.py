"""curionav resume DIR: continue a run, or every run of a sweep, after its last finished episode.

A resumed run or sweep is carried out by the command that began it, so this module imports those.
"""

from __future__ import annotations

import logging
import shlex
import sys
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from dataclasses import fields
from pathlib import Path
from typing import Any

import yaml

from curionav_cli.commands import dock, evaluate, explore, train
from curionav_cli.config.compose import pin
from curionav_cli.config.search import NOTE, noted
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import ConfigError, RunFailed, RunFolderError, SceneError, Terminated, UserError
from curionav_cli.execution.launch import INTERRUPTED, Request, state
from curionav_cli.files import read_json
from curionav_cli.live.settings import LINK
from curionav_cli.places import place
from curionav_cli.remote.settings import Remote
from curionav_cli.storage.older_runs import named_anew
from curionav_cli.storage.run_folder import RunFolder

# A run may be longer than planned, files may move, machines differ in memory, CUDA graphs may fail, and a probe only
# measures.
ANY = ("env.map", "env.mesh", "env.overlay", "loop.replay_memory", "compile", "logger", "results.probe_every")
IMAGES = "loop.keep"  # fewer of them than before, or more from now on
BEGUN = Path(".hydra", "hydra.yaml")  # the first file that Hydra writes
LONGER = "hydra.sweeper.n_trials"  # of a search, whose runs must stay equally long to be compared
PINNED = ("hydra.sweep.dir", "hydra.run.dir", "hydra.mode")
STORAGE = ("storage", *(f"remote.{field.name}" for field in fields(Remote)))  # where the storage is, and how it is used
ROBOT = tuple(f"robot.{name}" for name in LINK)  # of a real one
MAY_CHANGE = {"explore": ("loop.episodes", IMAGES, "init", *ANY, "env.floor", *ROBOT, *STORAGE),
              "train": ("loop.iterations", "data", "init", *ANY, *STORAGE),
              "dock": ("dock.requests", *ANY), "evaluate": ("loop.episodes", IMAGES, "init", *ANY)}
COMMANDS = {"explore": explore, "train": train, "dock": dock, "evaluate": evaluate}


def run(folder: Path, changes: list[str], failed: bool = False) -> int:
    """Continue the run or the sweep in `folder`; returns the exit code. changes: such as ["loop.episodes=20"].

    failed: also run the failed runs of a sweep again; a single run is always run again.
    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    folder = place(folder)
    if (folder / NOTE).is_file():
        if failed and "n_trials" in noted(folder):
            raise ConfigError("A search records each trial once, so failed trials are not run again. "
                              f"For more trials: curionav resume {folder} {LONGER}={2 * noted(folder)['n_trials']}")
        if failed and all(state(RunFolder(path.parent)) != "failed" for path in folder.glob("*/status.json")):
            print(f"No run in {folder} has failed.")
        return run_again(folder / NOTE, folder.resolve(), changes, multirun=True, failed=failed)
    if (folder / BEGUN).is_file() and not any((folder / name).is_file() for name in ("config.yaml", "metrics.jsonl")):
        return run_again(folder / BEGUN, folder.resolve(), changes, multirun=False, failed=True)
    existing = RunFolder.existing(folder)
    command = began_by(folder / "run.json")
    refuse_other_changes(command, changes)
    settings = read_settings(existing.config, changes)
    module: Any = COMMANDS[command]
    try:
        with logged(folder / f"{command}.log"):
            module.work(settings, folder)
    except (ConfigError, SceneError) as error:  # these name the setting
        raise RunFolderError(f"{existing.config} cannot be run: {error}") from error
    except KeyboardInterrupt:
        print(f"Interrupted. To go on: curionav resume {folder}", file=sys.stderr)
        return INTERRUPTED
    except Terminated:
        raise Terminated(f"Stopped by SIGTERM. To go on: curionav resume {folder}") from None
    module.summary(folder, [])
    return 0


def began_by(about: Path) -> str:
    """The command that began the run. Raises RunFolderError where run.json has none."""
    try:
        command = shlex.split(read_json(about)["command"])[1]
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise RunFolderError(f"{about} does not say what began the run ({error}). Restore it from a copy.") from error
    if command not in COMMANDS:
        raise RunFolderError(f"{about} names curionav {command}, which begins no run. Restore it from a copy.")
    return command


def refuse_other_changes(command: str, changes: list[str], searched: bool = False) -> None:
    """Check that a run of this command, or a search of them, may change so. Raises ConfigError."""
    may = (LONGER, *MAY_CHANGE[command][1:]) if searched else MAY_CHANGE[command]
    for key in (change.partition("=")[0] for change in changes):
        if key not in may:
            raise ConfigError(f"{key} may not change: a run keeps the settings that it began with. Start a new run "
                              f"for another value. What may change: {', '.join(may)}.")


def run_again(note: Path, folder: Path, changes: list[str], multirun: bool, failed: bool) -> int:
    """Give the command that Hydra recorded once more, with the same folder; returns the exit code.

    Finished runs of a sweep return at once, and runs that never began begin. A single run comes here only if it was
    killed before its folder had settings.
    """
    try:
        hydra = yaml.safe_load(note.read_text())["hydra"]
        overrides, where = hydra["overrides"], Path(hydra["runtime"]["cwd"])
        command, searched = hydra["job"]["name"], "n_trials" in hydra["sweeper"]
        module: Any = COMMANDS[command]
        own = [Path(source["path"]) for source in hydra["runtime"]["config_sources"] if source["provider"] == "user"]
    except (yaml.YAMLError, KeyError, TypeError) as error:
        raise RunFolderError(f"{note} does not hold the command ({error}). Restore it from a copy.") from error
    refuse_other_changes(command, changes, searched)
    keys = {change.partition("=")[0] for change in changes}
    words = [word for word in map(named_anew, overrides["task"]) if word.partition("=")[0] not in keys]
    kept = [word for word in overrides["hydra"] if word.partition("=")[0] not in {*PINNED, *keys}]
    request = Request(command, [*words, *changes, *kept, pin(folder, multirun)], multirun,
                      config_dirs=tuple(own), skip_failed=not failed)
    with chdir(where if where.is_dir() else folder):
        return module.run(request)


@contextmanager
def logged(path: Path) -> Iterator[None]:
    """Write the traceback of an unexpected error into the run's log, and raise RunFailed with one line."""
    handler = logging.FileHandler(path)
    log = logging.getLogger("curionav")
    log.addHandler(handler)
    log.propagate = False
    try:
        yield
    except (UserError, RunFailed):
        raise
    except Exception as error:
        log.exception("the run failed")
        raise RunFailed(f"{type(error).__name__}: {error}\nThe traceback is in {path}") from error
    finally:
        log.removeHandler(handler)
        log.propagate = True
        handler.close()
