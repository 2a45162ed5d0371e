"""Says once, in plain words, when the reward can tell nothing apart."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

ENOUGH = 2000  # steps before a warning means something
SHARE = 0.95


class RewardMonitor:
    """Counts over a life. ceiling: the reward of a step on which all that is counted is new."""

    def __init__(self, ceiling: float) -> None:
        self.ceiling = ceiling
        self.steps = self.poses = self.keys = 0
        self.bonus = 0.0
        self.rung: set[str] = set()

    def look(self, poses: int, keys: int, bonus: np.ndarray) -> None:
        """One more episode: how many different poses it had, how many different keys, and its rewards (N,)."""
        self.steps, self.poses, self.keys = self.steps + len(bonus), self.poses + poses, self.keys + keys
        self.bonus += float(bonus.sum())
        if self.steps < ENOUGH:
            return
        unique, mean = self.keys / max(1, self.poses), self.bonus / self.steps
        if unique > SHARE:
            self.ring("key", f"the key of a picture is degenerate: {unique:.1%} of the poses of an episode have a key "
                             "of their own, so that counts tell nothing; agent.key=grey_16 or grey_8 is coarser")
        if mean > SHARE * self.ceiling:
            self.ring("ceiling", f"the reward sits at its ceiling: {mean:.3f} of {self.ceiling:g} on average, so "
                                 "that no action is better than another")

    def ring(self, name: str, text: str) -> None:
        if name not in self.rung:
            self.rung.add(name)
            warnings.warn(text, stacklevel=4)

    def state(self) -> dict[str, Any]:
        return {"steps": self.steps, "poses": self.poses, "keys": self.keys, "bonus": self.bonus,
                "rung": sorted(self.rung)}

    def load_state(self, state: dict[str, Any]) -> None:
        self.steps, self.poses, self.keys, self.bonus = (state[key] for key in ("steps", "poses", "keys", "bonus"))
        self.rung = set(state["rung"])
