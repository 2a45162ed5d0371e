"""Warnings about a reward that cannot tell steps apart."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

ENOUGH = 2000  # steps before a warning means something
SHARE = 0.95


class RewardMonitor:
    """Watches a reward over the run, and warns once of each fault.

    ceiling: the reward of a step on which all that is counted is new (inf: none).
    """

    def __init__(self, ceiling: float) -> None:
        self.ceiling = ceiling
        self.steps = self.poses = self.keys = 0
        self.bonus = 0.0
        self.warned: set[str] = set()

    def update(self, poses: int, keys: int, bonus: np.ndarray) -> None:
        """Count an episode: its number of different poses and of different keys, and its rewards (N,)."""
        self.steps, self.poses, self.keys = self.steps + len(bonus), self.poses + poses, self.keys + keys
        self.bonus += float(bonus.sum())
        if self.steps < ENOUGH:
            return
        unique, mean = self.keys / max(1, self.poses), self.bonus / self.steps
        if unique > SHARE:
            self.warn_once("key", f"the key of a picture is degenerate: {unique:.1%} of the poses of an episode have a "
                                  "key of their own, so that counts carry no information; agent.key=grey_16 or grey_8 "
                                  "is coarser")
        if mean > SHARE * self.ceiling:
            self.warn_once("ceiling", f"the reward sits at its ceiling: {mean:.3f} of {self.ceiling:g} on average, so "
                                      "that no action is better than another")

    def warn_once(self, name: str, text: str) -> None:
        """Warn, unless it was done before in this run."""
        if name not in self.warned:
            self.warned.add(name)
            warnings.warn(text, stacklevel=4)

    def state(self) -> dict[str, Any]:
        """Return what a checkpoint keeps, as JSON has it."""
        return {"steps": self.steps, "poses": self.poses, "keys": self.keys, "bonus": self.bonus,
                "rung": sorted(self.warned)}

    def load_state(self, state: dict[str, Any]) -> None:
        """Restore what `state` returned."""
        self.steps, self.poses, self.keys, self.bonus = (state[key] for key in ("steps", "poses", "keys", "bonus"))
        self.warned = set(state["rung"])
