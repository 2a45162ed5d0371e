"""Replay is a folder of episodes. Reopening the folder restores it; sending one is copying a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from curionav_cli.records import Episode

NO_ACTION = -1


class Replay:
    """Uniform windows over all stored steps; a window never leaves its episode.

    B windows of L consecutive observations, as `sample` returns them:
        image     (B, L, 64, 64, 3) uint8
        action    (B, L) int64, the action that led to the observation; NO_ACTION at the window's
                  first, because the model starts there from a zero state
        pose      (B, L, 3) float64, metres and radians
        is_start  (B,) bool, the window's first observation is the first of an episode
    """

    def __init__(self, episodes: list[Episode] | None = None):
        self.episodes: list[Episode] = list(episodes or [])

    def add(self, episode: Episode) -> None:
        self.episodes.append(episode)

    def __len__(self) -> int:
        return len(self.episodes)

    def episode(self, index: int) -> Episode:
        """Number `index`, from the end where it is negative."""
        return self.episodes[index]

    @property
    def steps(self) -> int:
        return sum(len(episode) for episode in self.episodes)

    @classmethod
    def open(cls, paths: list[Path]) -> Replay:
        """The episodes in these files, in this order."""
        return cls([Episode.load(path) for path in paths])

    def sample(self, batch: int, length: int, rng: np.random.Generator) -> dict[str, np.ndarray]:
        """Draw B windows. Raises ValueError where no episode holds `length` observations."""
        windows = np.array([max(0, len(episode) + 2 - length) for episode in self.episodes])
        last = np.cumsum(windows)
        if not len(last) or not last[-1]:
            raise ValueError(f"no episode holds a sequence of {length} observations; raise loop.steps")
        draw = rng.integers(0, last[-1], batch)
        which = np.searchsorted(last, draw, side="right")
        start = draw - (last - windows)[which]
        image = np.stack([self.episodes[e].image[s:s + length] for e, s in zip(which, start, strict=True)])
        action = np.full((batch, length), NO_ACTION, np.int64)
        for row, (e, s) in enumerate(zip(which, start, strict=True)):
            action[row, 1:] = self.episodes[e].action[s:s + length - 1]
        pose = np.stack([self.episodes[e].pose[s:s + length] for e, s in zip(which, start, strict=True)])
        return {"image": image, "action": action, "is_start": start == 0, "pose": pose}
