"""What surprise is high and what is usual now: running windows of measurements, in nats."""

from __future__ import annotations

import numpy as np

KEPT = 500  # measurements of each window
DECAY = 0.998  # of the sums over past measurements, at each new one
MARGIN = 1.1  # of what is usual, that a place not yet seen is expected to have at least
LEAST, MOST = 0.2, 2.0  # bounds of the fading after an episode


class Levels:
    """The newest measurements, and those of first sights as multiples of what was usual then.

    recent, first: (n,) float32, n <= KEPT, oldest first. pairs: (5,) running sums of 1, x, y, x x and x y, where x is
    what the map remembered of a place and y what was then measured there. fade: by how much a place's surprise changes
    when the model has learned from an episode that saw it; old, new: sums of what was remembered, and then measured.
    """

    SAVED = ("recent", "first", "pairs", "fading")

    def __init__(self, optimism: float):
        self.optimism = optimism
        self.recent, self.first = np.zeros(0, np.float32), np.zeros(0, np.float32)
        self.pairs = np.zeros(5)
        self.fade, self.old, self.new = 1.0, 0.0, 0.0

    @property
    def usual(self) -> float:
        """The median of the newest measurements; one before there is any."""
        return float(np.median(self.recent)) if len(self.recent) else 1.0

    @property
    def expected(self) -> float:
        """The surprise that a place not yet seen is expected to have: a high quantile of first sights."""
        return self.usual * max(MARGIN, float(np.quantile(self.first, self.optimism)) if len(self.first) else 0.0)

    def add(self, surprise: float) -> None:
        """A measurement."""
        self.recent = np.append(self.recent, np.float32(surprise))[-KEPT:]

    def add_first(self, surprise: float) -> None:
        """A measurement from a place where the robot had never been."""
        self.first = np.append(self.first, np.float32(surprise / max(self.usual, 1e-6)))[-KEPT:]

    @property
    def trust(self) -> float:
        """How much of a difference on the map is found again: the slope of measured on remembered, from 0 to 1.

        Within an episode successive views are alike, so that only what an earlier episode remembered is compared.
        """
        n, x, y, xx, xy = self.pairs
        spread = n * xx - x * x
        return float(np.clip((n * xy - x * y) / spread, 0.0, 1.0)) if spread > 1e-9 * n * xx else 0.0

    @property
    def remembered(self) -> float:
        """The mean of what the map remembered of the places that were seen again in a later episode."""
        return float(self.pairs[1] / self.pairs[0]) if self.pairs[0] else self.usual

    def met_again(self, remembered: float, measured: float) -> None:
        """A view of places last seen in an earlier episode: the mean of what the map remembered, and its surprise."""
        self.old, self.new = self.old + remembered, self.new + measured
        self.pairs = DECAY * self.pairs + (1.0, remembered, measured, remembered**2, remembered * measured)

    def end_of_episode(self) -> float:
        """The model has learned: the factor for the places of the episode before, corrected by what was met again."""
        if self.old > 0.0:
            self.fade = float(np.clip(self.fade * np.sqrt(self.new / self.old), LEAST, MOST))
        self.old = self.new = 0.0
        return self.fade

    def save(self) -> dict[str, np.ndarray]:
        """The arrays that `load` restores."""
        return {"recent": self.recent, "first": self.first, "pairs": self.pairs,
                "fading": np.array([self.fade, self.old, self.new])}

    def load(self, arrays: dict[str, np.ndarray]) -> None:
        """What `save` gave."""
        self.recent, self.first, self.pairs = arrays["recent"], arrays["first"], arrays["pairs"]
        self.fade, self.old, self.new = arrays["fading"].tolist()
