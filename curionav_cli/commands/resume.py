"""curionav resume DIR: a run, or every run of a sweep, goes on from its last finished episode."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import chdir, contextmanager
from pathlib import Path

import yaml

from curionav_cli.commands import explore
from curionav_cli.commands.launch import INTERRUPTED, Request
from curionav_cli.config.preflight import pin
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import ConfigError, RunFailed, RunFolderError, UserError
from curionav_cli.storage.run_folder import RunFolder

# A run may be longer than planned, files may move, machines differ in memory, and CUDA graphs may fail.
MAY_CHANGE = ("loop.episodes", "env.map", "env.overlay", "loop.replay_memory", "compile")


def run(folder: Path, changes: list[str]) -> int:
    """Go on with the run or the sweep in `folder`; changes: ["loop.episodes=20"]. The exit code.

    Raises UserError before anything is written, RunFailed where the run cannot go on.
    """
    for change in changes:
        key = change.partition("=")[0]
        if key not in MAY_CHANGE:
            raise ConfigError(f"A run goes on with the settings it began with; only {', '.join(MAY_CHANGE)} may "
                              f"change, not {key}. Start a new run for another one.")
    if (folder / "multirun.yaml").is_file():
        return resume_sweep(folder.resolve(), changes)
    one = RunFolder.existing(folder)
    settings = read_settings(one.config, changes)
    try:
        with logged(folder / "explore.log"):
            explore.explore(settings, folder)
    except KeyboardInterrupt:
        print(f"Interrupted. To go on: curionav resume {folder}", file=sys.stderr)
        return INTERRUPTED
    explore.summary(folder, [])
    return 0


def resume_sweep(folder: Path, changes: list[str]) -> int:
    """Sweep again into the same folders: what is done returns at once, what never began begins."""
    try:
        noted = yaml.safe_load((folder / "multirun.yaml").read_text())["hydra"]
        overrides, where = noted["overrides"], Path(noted["runtime"]["cwd"])
        own = [Path(source["path"]) for source in noted["runtime"]["config_sources"] if source["provider"] == "user"]
    except (yaml.YAMLError, KeyError, TypeError) as error:
        raise RunFolderError(f"{folder / 'multirun.yaml'} does not hold a sweep ({error}).") from error
    keys = {change.partition("=")[0] for change in changes}
    words = [word for word in overrides["task"] if word.partition("=")[0] not in keys]
    hydra = [word for word in overrides["hydra"] if word.partition("=")[0] not in ("hydra.sweep.dir", "hydra.mode")]
    request = Request("explore", [*words, *changes, *hydra, pin(str(folder), multirun=True)], multirun=True,
                      config_dir=own[0] if own else None)
    with chdir(where if where.is_dir() else folder):
        return explore.run(request)


@contextmanager
def logged(path: Path) -> Iterator[None]:
    """The traceback of an unexpected end goes into the run's log; a person reads one line."""
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
