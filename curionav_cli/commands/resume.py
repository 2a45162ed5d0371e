"""curionav resume DIR: a run, or every run of a sweep, goes on from its last finished episode."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from curionav_cli.commands.explore import explore, summary
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import ConfigError
from curionav_cli.storage.run_folder import RunFolder


def run(folder: Path, changes: list[str]) -> int:
    """Go on with the run in `folder`, or with the runs in it; changes: ["loop.episodes=20"]. The exit code.

    Raises UserError before anything is written, RunFailed where a run cannot go on.
    """
    for one in RunFolder.found(folder):
        explore(changed(read_settings(one.config), changes), one.path)
    summary(folder, [])
    return 0


def changed(settings: Config, changes: list[str]) -> Config:
    """A run may be longer than was planned; anything else would make it another run."""
    for change in changes:
        key, _, value = change.partition("=")
        if key != "loop.episodes":
            raise ConfigError("A run goes on with the settings it began with; only loop.episodes may change, "
                              f"not {key}. Start a new run for another one.")
        if not value.isdecimal() or int(value) < 1:
            raise ConfigError(f"loop.episodes: {value!r} is not a number of episodes")
        settings = replace(settings, loop=replace(settings.loop, episodes=int(value)))
    return settings
