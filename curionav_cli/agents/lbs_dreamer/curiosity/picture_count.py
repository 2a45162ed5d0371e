"""Counts of pictures, which a robot can keep: #Exploration (Tang et al., 2017, section 2.3).

    r = 1 / sqrt(N(phi(x)))

phi is the sign of random projections of the picture in 8 x 8 cells of grey (SimHash, as C-BET's keys are made).
No true position is asked for, as the oracle in count.py does; two places that look alike are one.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.agents.image_hash import StateKeys
from curionav_cli.agents.lbs_dreamer.curiosity.count import Count
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import Notes
from curionav_cli.records import FloorPlan
from curionav_cli.storage.replay import Replay

GRID, BITS = "grey_8", 64
PROJECTIONS = 0  # their seed: the same ones in every run


class PictureCount(Count):
    """The bonus of the picture's key."""

    def notes(self, plan: FloorPlan) -> Notes:
        return Pictures()


class Pictures:
    """How often each picture's key was met, the agent's whole life long."""

    def __init__(self) -> None:
        self.keys = StateKeys(GRID, BITS, np.random.default_rng(PROJECTIONS))
        self.table: dict[bytes, int] = {}  # key -> its number
        self.numbers: list[np.ndarray] = []  # of each episode's frames
        self.counts = np.zeros(0, np.float32)

    def take_in(self, replay: Replay) -> None:
        """Count the episodes that are new."""
        for index in range(len(self.numbers), len(replay)):
            keys = self.keys(replay.episode(index).image)
            self.numbers.append(np.array([self.table.setdefault(key, len(self.table)) for key in keys]))
        self.counts = np.bincount(np.concatenate(self.numbers)).astype(np.float32)

    def of(self, which: np.ndarray, start: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """Of windows that were drawn, (B, L) float32. which, start: (B,); pose: (B, L, 3)."""
        steps = np.arange(pose.shape[1])
        return np.stack([self.counts[self.numbers[e][s + steps]] for e, s in zip(which, start)])
