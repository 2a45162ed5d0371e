"""Stored episodes that a learner is given: where they are, and whether they are still what they were."""

from __future__ import annotations

from pathlib import Path

from curionav_cli.errors import RunFolderError
from curionav_cli.files import checksum, read_arrays
from curionav_cli.records import held
from curionav_cli.storage.run_folder import RunFolder


def names(data: Path) -> list[str]:
    """Paths below `data`, in order: of a run's episodes, of those of all runs of a sweep, or of its npz files.

    Raises RunFolderError where there are none, or where one is missing between others of its run.
    """
    if not data.is_dir():
        raise RunFolderError(f"data: there is no folder {data}.")
    lived = runs(data)
    for run in lived:
        run.refuse_holes()
    paths = [path for run in lived for path in run.episode_paths()] if lived else sorted(data.glob("*.npz"))
    if not paths:
        raise RunFolderError(f"data: {data} holds no episodes. Give the folder of a run, of a sweep, "
                             "or one with npz files of episodes in it.")
    return [path.relative_to(data).as_posix() for path in paths]


def runs(data: Path) -> list[RunFolder]:
    """The run, or those of the sweep, at `data`; none where it just holds episodes."""
    return RunFolder.inside(data) or ([RunFolder(data)] if (data / "config.yaml").is_file() else [])


def environments(data: Path) -> list[str]:
    """Where the runs at `data` were lived; nothing is known of a folder that just holds episodes."""
    return sorted({str(run.settings["env"]["name"]) for run in runs(data)})


def checksums(data: Path, episodes: list[str]) -> dict[str, str]:
    """What each episode holds, in short. Raises RunFolderError where one is broken or missing."""
    if not data.is_dir():
        raise RunFolderError(f"data: there is no folder {data}. If it moved, name it: data=...")
    return {name: checksum(data / name) for name in episodes}


def longest(data: Path, episodes: list[str], repeat: int = 1) -> int:
    """Actions of the longest episode, each held for `repeat` steps.

    Raises RunFolderError where one is broken, or holds its actions for another time.
    """
    return max(len(held(read_arrays(data / name, ("action",))["action"], repeat, data / name)) for name in episodes)
