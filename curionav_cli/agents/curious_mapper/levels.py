"""What surprise is high and what is usual now: running windows of measurements, in nats."""

from __future__ import annotations

import numpy as np

KEPT = 500  # measurements of each window
DECAY = 0.8  # of what ended episodes say about the trust, at the end of each
MARGIN = 1.1  # of what is usual, that a place not yet seen is expected to have at least
LEAST, MOST = 0.2, 2.0  # bounds of the fading after an episode


class Levels:
    """The newest measurements, and those of first sights as multiples of what was usual then.

    recent, first: (n,) float32, n <= KEPT, oldest first. pairs: (5,) this episode's sums of 1, x, y, x x and x y, where
    x is what the map remembered of a place and y what was then measured there. scatter: (2,) of ended episodes, the
    sums of squares of x and of products of x and y, about the means of their own episode. fade: by how much a place's
    surprise changes when the model has learned from an episode that saw it.
    """

    SAVED = ("recent", "first", "pairs", "scatter", "fading")

    def __init__(self, optimism: float):
        self.optimism = optimism
        self.recent, self.first = np.zeros(0, np.float32), np.zeros(0, np.float32)
        self.pairs, self.scatter = np.zeros(5), np.zeros(2)
        self.fade = 1.0

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

        Within an episode successive views are alike, so that only what an earlier episode remembered is compared. From
        one episode to the next all surprise rises or falls with the model, which says nothing of places: so both are
        taken about their means in the episode.
        """
        squares, products = self.scatter + scatter(self.pairs)
        return float(np.clip(products / squares, 0.0, 1.0)) if squares > 1e-9 else 0.0

    @property
    def remembered(self) -> float:
        """The mean of what the map remembered of the places that were seen again in this episode."""
        return float(self.pairs[1] / self.pairs[0]) if self.pairs[0] else self.usual

    def met_again(self, remembered: float, measured: float) -> None:
        """A view of places last seen in an earlier episode: the mean of what the map remembered, and its surprise."""
        self.pairs += (1.0, remembered, measured, remembered**2, remembered * measured)

    def end_of_episode(self) -> float:
        """The model has learned: the factor for the places of the episode before, corrected by what was met again."""
        _, old, new, _, _ = self.pairs
        if old > 0.0:
            self.fade = float(np.clip(self.fade * np.sqrt(new / old), LEAST, MOST))
        self.scatter = DECAY * self.scatter + scatter(self.pairs)
        self.pairs = np.zeros(5)
        return self.fade

    def save(self) -> dict[str, np.ndarray]:
        """The arrays that `load` restores."""
        return {"recent": self.recent, "first": self.first, "pairs": self.pairs, "scatter": self.scatter,
                "fading": np.array(self.fade)}

    def load(self, arrays: dict[str, np.ndarray]) -> None:
        """What `save` gave."""
        self.recent, self.first, self.pairs = arrays["recent"], arrays["first"], arrays["pairs"]
        self.scatter, self.fade = arrays["scatter"], float(arrays["fading"])


def scatter(pairs: np.ndarray) -> np.ndarray:
    """(2,) sums of squares of x and of products of x and y about their means. pairs: (5,) as Levels.pairs."""
    n, x, y, xx, xy = pairs
    return np.array([xx - x * x / n, xy - x * y / n]) if n else np.zeros(2)
