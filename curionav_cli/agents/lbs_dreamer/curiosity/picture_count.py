"""Counts of image keys, which a robot can measure: #Exploration (Tang et al., 2017, section 2.3).

    r = 1 / sqrt(N(phi(x)))

phi is the sign of random projections of the image in 8 x 8 cells of grey (SimHash, as C-BET's keys, image_hash.py).
It needs no true position, unlike the oracle in count.py; two places that look alike count as one.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.agents.image_hash import StateKeys
from curionav_cli.agents.lbs_dreamer.curiosity.count import Count
from curionav_cli.agents.lbs_dreamer.curiosity.curiosity import VisitCounts
from curionav_cli.records import FloorPlan
from curionav_cli.storage.replay import Replay

GRID, BITS = "grey_8", 64
PROJECTIONS = 0  # their seed: the same ones in every run


class PictureCount(Count):
    """Bonus of the key of a state's image."""

    def visit_counts(self, plan: FloorPlan) -> VisitCounts:
        """Counts by the keys of images; the plan is not used."""
        return KeyCounts()


class KeyCounts:
    """Counts how often each image key was met, over all episodes of the run."""

    def __init__(self) -> None:
        self.keys = StateKeys(GRID, BITS, np.random.default_rng(PROJECTIONS))
        self.table: dict[bytes, int] = {}  # key -> its number
        self.numbers: list[np.ndarray] = []  # of each episode's frames
        self.counts = np.zeros(0, np.float32)

    def update(self, replay: Replay) -> None:
        """Count the episodes that are new in the replay."""
        for index in range(len(self.numbers), len(replay)):
            keys = self.keys(replay.episode(index).image)
            self.numbers.append(np.array([self.table.setdefault(key, len(self.table)) for key in keys]))
        self.counts = np.bincount(np.concatenate(self.numbers)).astype(np.float32)

    def of_windows(self, which: np.ndarray, start: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """Counts (B, L) float32 of the keys of episode `which` (B,) from frame `start` (B,); pose (B, L, 3)."""
        steps = np.arange(pose.shape[1])
        return np.stack([self.counts[self.numbers[e][s + steps]] for e, s in zip(which, start)])
