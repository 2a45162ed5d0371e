"""Stored episodes for offline training: where they are, and whether they have changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.decisions import Every
from curionav_cli.errors import RunFolderError
from curionav_cli.files import checksum, read_arrays
from curionav_cli.records import GONE
from curionav_cli.storage.run_folder import RunFolder

CURE = "Where it kept some, set agent.action_repeat or agent.options as in that run."


def names(data: Path) -> list[str]:
    """Paths of episodes relative to `data`, in order: of a run, of all runs of a sweep, or of a folder of npz files.

    Raises RunFolderError where there are none, or where one is missing between others of its run.
    """
    if not data.is_dir():
        raise RunFolderError(f"data: {data} is neither a folder nor a bag (.mcap, .bag, .db3)." if data.exists() else
                             f"data: there is no folder {data}.")
    folders = runs(data)
    for run in folders:
        run.refuse_holes()
    paths = [path for run in folders for path in run.episode_paths()] if folders else sorted(data.glob("*.npz"))
    if not paths:
        raise RunFolderError(f"data: {data} holds no episodes. Give the folder of a run, of a sweep, "
                             "or one with npz files of episodes or bags in it; or a bag.")
    return [path.relative_to(data).as_posix() for path in paths]


def runs(data: Path) -> list[RunFolder]:
    """The run, or the runs of the sweep, at `data`; none where it is a plain folder of episodes."""
    return RunFolder.inside(data) or ([RunFolder(data)] if (data / "config.yaml").is_file() else [])


def environments(data: Path) -> list[str]:
    """Names of the environments of the runs at `data`; none of a plain folder of episodes."""
    return sorted({str(run.settings["env"]["name"]) for run in runs(data)})


def collected_by(data: Path) -> list[dict[str, Any]]:
    """Agent settings and seed of each run at `data`; none of a plain folder of episodes."""
    return [{key: run.settings[key] for key in ("agent", "seed")} for run in runs(data)]


def checksums(data: Path, episodes: list[str]) -> dict[str, str]:
    """A checksum of each episode, by name. Raises RunFolderError where one is broken or missing."""
    if not data.is_dir():
        raise RunFolderError(f"data: there is no folder {data}. If it moved, name it: data=...")
    return {name: checksum(data / name) for name in episodes}


def longest(data: Path, episodes: list[str], every: Every) -> int:
    """Number of choices in the episode that has most.

    Raises RunFolderError where one is broken, was recorded with other choices, or its images were not kept.
    """
    return max(choices(data / name, every) for name in episodes)


def choices(path: Path, every: Every) -> int:
    """Number of choices in an episode. Raises RunFolderError as `longest` does."""
    arrays = read_arrays(path, ("action", "collided"), ("kept",))
    frame = every.decisions(arrays["action"], arrays["collided"], path).frame
    if "kept" in arrays and not np.isin(frame, arrays["kept"]).all():
        raise RunFolderError(f"{GONE.format(path, len(arrays['kept']), len(arrays['action']) + 1)} For an agent "
                             f"with {every.unit} they are too few. {CURE}")
    return len(frame) - 1
