"""A checkpoint is a folder, whole or absent. Its content is the agent's business.

    checkpoint/
        000003/            after three finished episodes (of curionav train: iterations)
            settings.json  the settings that may not change when the run goes on
            ...            what agent.save wrote
            checksums.json of all these files (SHA-256), and of itself
            done           empty, written last
        000004/            the newest; the one before it is kept
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from curionav_cli.errors import RunFolderError, SoundnessWarning
from curionav_cli.files import CRC32, read_json
from curionav_cli.storage.older_runs import HELD

KEPT = 2
CHECKSUMS = "checksums.json"


def save(root: Path, done: int, settings: dict[str, Any], write: Callable[[Path], None]) -> None:
    """Save the state after `done` episodes or iterations; write(folder) fills it. Raises OSError."""
    beside = root / f"{done:06d}.part"
    shutil.rmtree(beside, ignore_errors=True)
    beside.mkdir(parents=True)
    (beside / "settings.json").write_text(json.dumps(settings, sort_keys=True))
    write(beside)
    (beside / CHECKSUMS).write_text(CRC32.sealed(checksums(beside)))
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
    """Have the operating system write a file, or the listing of a folder, to the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def finished(root: Path) -> list[Path]:
    """The whole checkpoints, oldest first."""
    whole = (folder for folder in root.glob("[0-9]*") if folder.name.isdecimal() and (folder / "done").exists())
    return sorted(whole, key=lambda folder: int(folder.name))


def checksums(folder: Path) -> dict[str, str]:
    """SHA-256 of every file in the folder, by path relative to it."""
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*")) if path.is_file() and path.name not in (CHECKSUMS, "done")}


def newest(root: Path, settings: dict[str, Any], built_on: Callable[[int], object] = int) -> tuple[int, Path] | None:
    """(finished episodes or iterations, folder) of the newest whole checkpoint; None where there is none.

    built_on(done) raises RunFolderError where what the checkpoint builds on, such as its episodes, is broken.
    A broken checkpoint that is passed over gives a SoundnessWarning. Raises RunFolderError where all are broken, or
    where the settings differ.
    """
    faults: list[RunFolderError] = []
    for folder in reversed(finished(root)):
        try:
            refuse_broken(folder)
            built_on(int(folder.name))
        except RunFolderError as error:
            faults.append(error)
            continue
        refuse_changes(root.parent, read_json(folder / "settings.json"), settings)
        for fault in faults:
            warnings.warn(f"{fault} Until then: the checkpoint after {int(folder.name)} is whole, and the run goes on "
                          "from there.", SoundnessWarning, stacklevel=2)
        return int(folder.name), folder
    if faults:
        raise faults[0]
    return None


def refuse_broken(folder: Path) -> None:
    """Raises RunFolderError that names the first file whose checksum differs; the oldest checkpoints hold none."""
    if not (folder / CHECKSUMS).exists():
        return
    noted, now = read_json(folder / CHECKSUMS), checksums(folder)
    for name in sorted(noted.keys() | now.keys()) if isinstance(noted, dict) else [CHECKSUMS]:
        if not isinstance(noted, dict) or noted.get(name) != now.get(name):
            raise RunFolderError(f"{folder / name} is not whole (its checksum is another one). Restore it from a copy.")


SAME = {f"{key} was null, now {json.dumps(value)}" for key, value in HELD.items()}  # no change since an older version


def refuse_changes(run: Path, was: dict[str, Any], now: dict[str, Any]) -> None:
    """Raises RunFolderError that names the first setting that differs, names of groups before their settings."""
    found = (line for line in differences(was, json.loads(json.dumps(now))) if line not in SAME)
    changed = sorted(found, key=lambda line: ".name was " not in line)
    if changed:
        raise RunFolderError(f"{run} cannot go on with other settings: {changed[0]}. "
                             "Put it back, or start a new run in another folder.")


def differences(was: Any, now: Any, key: str = "") -> list[str]:
    """One line 'key was A, now B' for every leaf in which two trees of settings differ."""
    if isinstance(was, dict) and isinstance(now, dict):
        keys = sorted(was.keys() | now.keys())
        return [line for k in keys for line in differences(was.get(k), now.get(k), f"{key}.{k}" if key else k)]
    return [] if was == now else [f"{key} was {brief(was)}, now {brief(now)}"]


def brief(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
