"""Images of stored episodes and predictions: which a run still has, and how they are removed to save room.

A thinned episode has all its numbers, and images of the frames `kept` alone; a thinned prediction has no images. A file
is replaced as a whole, so that a kill at any moment leaves the old one or the new one.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from curionav_cli.constants import IMAGE_SHAPE
from curionav_cli.errors import RunFolderError
from curionav_cli.files import SMALL, opened, read_arrays, understood, write_arrays
from curionav_cli.records import GONE, Episode

NO_FRAMES, NO_IMAGES = np.zeros(0, np.int64), np.zeros((0, *IMAGE_SHAPE), np.uint8)


def kept(path: Path) -> np.ndarray | None:
    """The frames (K,) of an episode's file whose images it holds; None for all. Raises RunFolderError."""
    return read_arrays(path, (), ("kept",)).get("kept")


def refuse_thinned(path: Path) -> None:
    """Raises RunFolderError where an episode's file is broken, or does not hold all its images any more."""
    held = kept(path)
    if held is not None:
        raise RunFolderError(GONE.format(path, len(held), len(read_arrays(path, ("action",))["action"]) + 1))


def gone(path: Path) -> bool:
    """Whether the file of an episode or a prediction holds no image any more. Raises RunFolderError where it is broken.
    """
    with opened(path) as archive:
        held = archive.namelist()
    return "image.npy" not in held and not ("kept.npy" in held and len(read_arrays(path, ("kept",))["kept"]))


def images(path: Path, frame: np.ndarray | list[int]) -> np.ndarray:
    """Images (n, 64, 64, 3) of these frames of an episode's file; -1 is the last.

    Raises RunFolderError where it is broken, or one of them was not kept.
    """
    episode = Episode.load(path, thinned=True)
    return episode.images(np.asarray(frame) % (len(episode) + 1), path)


def thin(path: Path, frame: np.ndarray) -> None:
    """Remove from an episode's file the images of all frames but these (n,), rising; others stay removed.

    Raises RunFolderError where it is broken, OSError where it cannot be written.
    """
    had = kept(path)
    left = frame if had is None else np.intersect1d(frame, had)
    if had is not None and len(left) == len(had):
        return
    if len(left):
        episode = Episode.load(path, thinned=True)
        replace(episode, image=episode.images(left, path), kept=left.astype(np.int64)).save(path)
    else:
        held = read_arrays(path, ("action", "pose", "collided", "events"), ("estimate", "dock"))
        write_arrays(path, {"kept": NO_FRAMES, "kept_image": NO_IMAGES, **held}, SMALL)


def thin_prediction(path: Path) -> None:
    """Remove the images of a prediction's file. Raises RunFolderError where it is broken, OSError as `thin` does."""
    names = ("step", "frame", "error", "repeat", *(f"surprise_{key}" for key in ("frame", "kl", "reward")))
    held = read_arrays(path, names, ("every", "image"))
    if held.pop("image", None) is not None:
        write_arrays(path, held, SMALL)


def numbers(path: Path) -> Episode:
    """An episode without its images: poses, actions, events. Raises RunFolderError where its file is broken."""
    held = read_arrays(path, ("action", "pose", "collided", "events"))
    with understood(path):
        events = tuple(json.loads(str(held["events"])))
    return Episode(NO_IMAGES, held["action"], held["pose"], held["collided"], events, kept=NO_FRAMES)
