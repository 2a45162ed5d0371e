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
NOT_HELD = -2  # as the length of an episode: no window fits


@dataclass(frozen=True)
class Stored:
    """An episode whose frames are in memory, or in the scratch file.

    frames: their shape, (T+1, 64, 64, 3). steps: of the environment that they cover. place: their offset in the scratch
    file in bytes, where episode.image is empty; None where they are in memory.
    """

    episode: Episode
    frames: tuple[int, ...]
    steps: int
    place: int | None = None


class Replay:
    """A replay buffer: draws windows uniformly over all stored steps; a window never leaves its episode.

    every: how often the agent chooses; only the frames at which it did are kept, as observations, and its choices are
    the actions.
    memory: bytes of frames kept in memory, of the first episodes that fit; it changes no window. The other frames are
    in an unnamed file in `folder` until `close`. Actions, poses and collisions of all episodes are in memory, 33 bytes
    an observation.
    newest: number of episodes held; None for all. Older ones keep their index, but no window is drawn from them.

    steps: of the environment that the held frames cover; a choice that an episode's end cut off is left out.

    B windows of L consecutive observations, as `sample` returns them:
        image     (B, L, 64, 64, 3) uint8
        action    (B, L) int64, the action that led to the observation; NO_ACTION at the window's
                  first, because the model starts there from a zero state
        pose      (B, L, 3) float64, metres and radians
        is_start  (B,) bool, the window's first observation is the first of an episode
    """

    def __init__(self, episodes: Iterable[Episode] = (), *, memory: float = math.inf, folder: Path | None = None,
                 every: Every = EACH_STEP, newest: int | None = None):
        self.memory, self.in_memory, self.every, self.steps = memory, 0, every, 0
        self.newest, self.dropped = newest, 0
        self._scratch = Scratch(folder)
        self._stored: list[Stored | None] = []  # None: not held any more
        self._lengths = np.zeros(0, np.int64)  # actions of each episode
        for episode in episodes:
            self.add(episode)

    @classmethod
    def open(cls, paths: Iterable[Path], *, memory: float = math.inf, folder: Path | None = None,
             every: Every = EACH_STEP, newest: int | None = None) -> Replay:
        """A replay of the episodes in these files, in this order.

        Raises RunFolderError where one is broken, was recorded with other choices, or its images were not kept.
        """
        replay, files = cls(memory=memory, folder=folder, every=every, newest=newest), list(paths)
        replay.pass_over(len(files) - (newest or len(files)))
        try:
            for path in files[len(replay):]:
                replay.add(Episode.load(path, thinned=True), path)
        except BaseException:
            replay.close()
            raise
        return replay

    def pass_over(self, episodes: int) -> None:
        """Count so many episodes, of a replay that is still empty, as not held any more."""
        self._stored = [None] * episodes
        self._lengths, self.dropped = np.full(len(self._stored), NOT_HELD), len(self._stored)

    def add(self, episode: Episode, what: object = "an episode") -> None:
        """Add an episode; `what` names it in messages.

        Raises OSError where the disk is full, RunFolderError where it has no such choices, or lacks images of them.
        """
        kept = self.every.decisions(episode.action, episode.collided, what)
        episode = episode.at(kept, what)
        if len(self) - self.dropped == self.newest:
            self._drop()
        frames, steps = episode.image.shape, int(kept.frame[-1])
        if self.in_memory + episode.image.nbytes <= self.memory:
            self._stored.append(Stored(episode, frames, steps))
            self.in_memory += episode.image.nbytes
        else:
            place = self._scratch.append(episode.image)
            self._stored.append(Stored(replace(episode, image=episode.image[:0].copy()), frames, steps, place))
        self._lengths = np.append(self._lengths, len(episode))
        self.steps += steps

    def _drop(self) -> None:
        """Let go of the oldest episode that is held."""
        stored = self.held(self.dropped)
        if stored.place is None:
            self.in_memory -= stored.episode.image.nbytes
        else:
            self._scratch.remove(stored.place, math.prod(stored.frames))
        self.steps -= stored.steps
        self._stored[self.dropped], self._lengths[self.dropped] = None, NOT_HELD
        self.dropped += 1

    def held(self, index: int) -> Stored:
        """Episode `index` as it is stored. Raises LookupError where it is not held any more."""
        stored = self._stored[index]
        if stored is None:
            raise LookupError(f"episode {index} is older than the newest {self.newest}, which the replay holds")
        return stored

    def __len__(self) -> int:
        """Number of episodes that were added, also of those not held any more."""
        return len(self._stored)

    @property
    def on_disk(self) -> int:
        """Bytes of the scratch file; `in_memory` has those of frames in memory."""
        return self._scratch.size

    def episode(self, index: int) -> Episode:
        """Episode `index`, read-only; -1 is the newest.

        Raises OSError where the scratch file cannot be read, LookupError where it is not held any more.
        """
        stored = self.held(index)
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
        image = np.empty((batch, length, *self.held(self.dropped).frames[1:]), np.uint8)
        self.frames(which, start, image)
        return {"image": image, **self.moves(which, start, length)}

    def frames(self, which: np.ndarray, start: np.ndarray, out: np.ndarray) -> None:
        """Read the images of windows that `draw` gave into `out` (B, L, 64, 64, 3) uint8."""
        for row, (e, s) in enumerate(zip(which.tolist(), start.tolist(), strict=True)):
            self._read(self.held(e), s, out[row])

    def moves(self, which: np.ndarray, start: np.ndarray, length: int) -> dict[str, np.ndarray]:
        """Everything but the images of windows that `draw` gave: action, pose, is_start."""
        action, pose = np.full((len(which), length), NO_ACTION, np.int64), np.empty((len(which), length, 3))
        for row, (e, s) in enumerate(zip(which.tolist(), start.tolist(), strict=True)):
            action[row, 1:] = self.held(e).episode.action[s:s + length - 1]
            pose[row] = self.held(e).episode.pose[s:s + length]
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
