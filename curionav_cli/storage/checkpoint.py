"""A checkpoint is a folder, finished or absent. What is in it is the agent's business.

    checkpoint/
        000003/            after three finished episodes (of curionav train: iterations)
            settings.json  the settings that the run may not change when it goes on
            ...            what agent.save wrote
            done           empty, written last
        000004/            the newest; the one before it is kept
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from curionav_cli.errors import RunFolderError
from curionav_cli.records import read_json

KEPT = 2


def save(root: Path, done: int, settings: dict[str, Any], write: Callable[[Path], None]) -> None:
    """Save the state after `done` episodes or iterations; write(folder) fills it."""
    beside = root / f"{done:06d}.part"
    shutil.rmtree(beside, ignore_errors=True)
    beside.mkdir(parents=True)
    (beside / "settings.json").write_text(json.dumps(settings, sort_keys=True))
    write(beside)
    for file in beside.rglob("*"):
        flush(file)
    (beside / "done").touch()
    flush(beside)
    final = at(root, done)
    shutil.rmtree(final, ignore_errors=True)
    beside.replace(final)
    flush(root)
    for old in finished(root)[:-KEPT]:
        shutil.rmtree(old)


def at(root: Path, done: int) -> Path:
    """The folder of the checkpoint after `done` episodes or iterations."""
    return root / f"{done:06d}"


def flush(path: Path) -> None:
    """Have the operating system put a file or a folder's listing on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def finished(root: Path) -> list[Path]:
    """The whole checkpoints, oldest first."""
    whole = (folder for folder in root.glob("[0-9]*") if folder.name.isdecimal() and (folder / "done").exists())
    return sorted(whole, key=lambda folder: int(folder.name))


def newest(root: Path, settings: dict[str, Any]) -> tuple[int, Path] | None:
    """(finished episodes or iterations, folder) to go on from. Raises RunFolderError where the settings differ."""
    folders = finished(root)
    if not folders:
        return None
    refuse_changes(root.parent, read_json(folders[-1] / "settings.json"), settings)
    return int(folders[-1].name), folders[-1]


def refuse_changes(run: Path, was: dict[str, Any], now: dict[str, Any]) -> None:
    """Raises RunFolderError that names the first setting that differs."""
    changed = differences(was, json.loads(json.dumps(now)))
    if changed:
        raise RunFolderError(f"{run} cannot go on with other settings: {changed[0]}. "
                             "Put it back, or start a new run in another folder.")


def differences(was: Any, now: Any, key: str = "") -> list[str]:
    """'key was A, now B' for every leaf that differs."""
    if isinstance(was, dict) and isinstance(now, dict):
        keys = sorted(was.keys() | now.keys())
        return [line for k in keys for line in differences(was.get(k), now.get(k), f"{key}.{k}" if key else k)]
    return [] if was == now else [f"{key} was {brief(was)}, now {brief(now)}"]


def brief(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
