"""curionav init DIR: make a config directory with a room, an agent and an experiment that run as they are."""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path

from curionav_cli.commands.summary import print_files, print_next
from curionav_cli.errors import ConfigError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import folder_for

STARTER = Path(__file__).parent / "starter"


def run(folder: Path) -> int:
    """Copy the starter files; returns the exit code. Raises ConfigError before any file would be overwritten."""
    names = sorted(path.relative_to(STARTER) for path in STARTER.rglob("*.yaml"))
    folder = folder_for(folder)
    there = [name for name in names if (folder / name).exists()]
    if there:
        raise ConfigError(f"{folder / there[0]} exists already. Name another folder, or remove it first.")
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(STARTER / name, folder / name)
    console, where = a_console(), shlex.quote(str(folder))
    print_files(console, folder, [str(name) for name in names])
    print_next(console, [f"curionav explore -cd {where} experiment=my_sweep   (runs as it is)",
                         f"curionav sheet -cd {where} env=my_room   (pictures of the room)",
                         f"export CURIONAV_CONFIG_PATH={shlex.quote(str(folder.absolute()))}   (instead of -cd)"])
    return 0
