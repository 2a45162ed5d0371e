"""Replay: uniform windows over stored episodes. It is restored from the folder of episodes alone.

Frames beyond a bound of memory are kept raw in a scratch file. A batch of 50 x 50 frames took 2.7 CPU-ms from memory,
5.4 by pread from a cached file, and 52 ms of waiting from a cold disk (mapped: 5.2, 297; inflating 50 npz: 1500).
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from curionav_cli.decisions import EACH_STEP, Every
from curionav_cli.records import Episode
from curionav_cli.storage.scratch import Scratch

NO_ACTION = -1


@dataclass(frozen=True)
class Stored:
    """An episode whose frames are in memory, or in the scratch file.

    frames: their shape, (T+1, 64, 64, 3). place: their offset in the scratch file in bytes, where episode.image is
    empty; None where they are in memory.
    """

    episode: Episode
    frames: tuple[int, ...]
    place: int | None = None


class Replay:
    """A replay buffer: draws windows uniformly over all stored steps; a window never leaves its episode.

    every: how often the agent chooses; only the frames at which it did are kept, as observations, and its choices are
    the actions.
    memory: bytes of frames kept in memory, of the first episodes that fit; it changes no window. The other frames are
    in an unnamed file in `folder` until `close`. Actions, poses and collisions of all episodes are in memory, 33 bytes
    an observation.

    steps: of the environment that the stored frames cover; a choice that an episode's end cut off is left out.

    B windows of L consecutive observations, as `sample` returns them:
        image     (B, L, 64, 64, 3) uint8
        action    (B, L) int64, the action that led to the observation; NO_ACTION at the window's
                  first, because the model starts there from a zero state
        pose      (B, L, 3) float64, metres and radians
        is_start  (B,) bool, the window's first observation is the first of an episode
    """

    def __init__(self, episodes: Iterable[Episode] = (), *, memory: float = math.inf, folder: Path | None = None,
                 every: Every = EACH_STEP):
        self.memory, self.in_memory, self.every, self.steps = memory, 0, every, 0
        self._scratch = Scratch(folder)
        self._stored: list[Stored] = []
        self._lengths = np.zeros(0, np.int64)  # actions of each episode
        for episode in episodes:
            self.add(episode)

    @classmethod
    def open(cls, paths: Iterable[Path], *, memory: float = math.inf, folder: Path | None = None,
             every: Every = EACH_STEP) -> Replay:
        """A replay of the episodes in these files, in this order.

        Raises RunFolderError where one is broken, or was recorded with other choices.
        """
        replay = cls(memory=memory, folder=folder, every=every)
        try:
            for path in paths:
                replay.add(Episode.load(path))
        except BaseException:
            replay.close()
            raise
        return replay

    def add(self, episode: Episode) -> None:
        """Add an episode. Raises OSError where the disk is full, RunFolderError where it has no such choices."""
        kept = self.every.decisions(episode.action, episode.collided)
        episode = episode.at(kept)
        frames = episode.image.shape
        if self.in_memory + episode.image.nbytes <= self.memory:
            self._stored.append(Stored(episode, frames))
            self.in_memory += episode.image.nbytes
        else:
            place = self._scratch.append(episode.image)
            self._stored.append(Stored(replace(episode, image=episode.image[:0].copy()), frames, place))
        self._lengths = np.append(self._lengths, len(episode))
        self.steps += int(kept.frame[-1])

    def __len__(self) -> int:
        """Number of episodes."""
        return len(self._stored)

    @property
    def on_disk(self) -> int:
        """Bytes of frames in the scratch file; `in_memory` has those in memory."""
        return self._scratch.size

    def episode(self, index: int) -> Episode:
        """Episode `index`, read-only; -1 is the newest. Raises OSError where the scratch file cannot be read."""
        stored = self._stored[index]
        if stored.place is None:
            return stored.episode
        image = np.empty(stored.frames, np.uint8)
        self._scratch.read(stored.place, image)
        return replace(stored.episode, image=image)

    def holds(self, length: int) -> bool:
        """Whether an episode holds `length` observations."""
        return bool((self._lengths + 2 > length).any())

    def draw(self, batch: int, length: int, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Draw windows: indices of episodes (B,) and of first observations (B,), each window equally likely.

        Raises ValueError where no episode holds `length` observations.
        """
        windows = np.maximum(0, self._lengths + 2 - length)
        last = np.cumsum(windows)
        if not len(last) or not last[-1]:
            raise ValueError(f"no episode holds a sequence of {length} observations; raise loop.steps")
        drawn = rng.integers(0, last[-1], batch)
        which = np.searchsorted(last, drawn, side="right")
        return which, drawn - (last - windows)[which]

    def sample(self, batch: int, length: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
        """Draw B windows of L observations, see the class for the arrays. Raises ValueError as `draw` does."""
        which, start = self.draw(batch, length, rng)
        image = np.empty((batch, length, *self._stored[0].frames[1:]), np.uint8)
        self.frames(which, start, image)
        return {"image": image, **self.moves(which, start, length)}

    def frames(self, which: np.ndarray, start: np.ndarray, out: np.ndarray) -> None:
        """Read the images of windows that `draw` gave into `out` (B, L, 64, 64, 3) uint8."""
        for row, (e, s) in enumerate(zip(which.tolist(), start.tolist(), strict=True)):
            self._read(self._stored[e], s, out[row])

    def moves(self, which: np.ndarray, start: np.ndarray, length: int) -> dict[str, np.ndarray]:
        """Everything but the images of windows that `draw` gave: action, pose, is_start."""
        action, pose = np.full((len(which), length), NO_ACTION, np.int64), np.empty((len(which), length, 3))
        for row, (e, s) in enumerate(zip(which.tolist(), start.tolist(), strict=True)):
            action[row, 1:] = self._stored[e].episode.action[s:s + length - 1]
            pose[row] = self._stored[e].episode.pose[s:s + length]
        return {"action": action, "is_start": start == 0, "pose": pose}

    def close(self) -> None:
        """Remove the scratch file."""
        self._scratch.close()

    def _read(self, stored: Stored, first: int, out: np.ndarray) -> None:
        """Frames `first` ... of an episode, as many as `out` holds."""
        if stored.place is None:
            out[:] = stored.episode.image[first:first + len(out)]
        else:
            self._scratch.read(stored.place + first * math.prod(stored.frames[1:]), out)
