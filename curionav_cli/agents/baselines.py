"""Baselines that do not learn: curiosity has to beat them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from curionav_cli.agents.agent import Agent
from curionav_cli.constants import ACTIONS, FORWARD, HEADINGS, LEFT, RIGHT
from curionav_cli.decisions import EACH_STEP, Every


class Random(Agent):
    """Draws one of the three actions, or one of the options of `every`, with equal probability."""

    def __init__(self, seed: int, every: Every = EACH_STEP):
        super().__init__(seed)
        self.every, self.execution = every, every.execution()

    def begin(self) -> None:
        self.execution.begin()

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        if self.execution.due(info):
            self.execution.start(int(self.rng.integers(len(self.every.names))))
        return self.execution.step()


class Sticky(Agent):
    """Repeats its last action with probability `repeat`, else draws one of the three: persistence without curiosity."""

    def __init__(self, seed: int, repeat: float):
        super().__init__(seed)
        self.repeat = repeat
        self.last: int | None = None

    def begin(self) -> None:
        self.last = None

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        if self.last is None or self.rng.random() >= self.repeat:
            self.last = int(self.rng.integers(len(ACTIONS)))
        return self.last


class Bounce(Agent):
    """Goes forward until a move is cut short, then turns by a random angle, as vacuum robots do.

    least, most: bounds of the turn in steps of 10 degrees, both included.
    """

    def __init__(self, seed: int, least: int, most: int):
        super().__init__(seed)
        self.least, self.most = least, most
        self.turns, self.direction = 0, LEFT

    @classmethod
    def turning(cls, seed: int, least: float, most: float) -> Bounce:
        """Make one that turns by `least` to `most` degrees, in whole steps."""
        step = 360 // HEADINGS
        fewest = math.ceil(least / step)
        return cls(seed, fewest, max(fewest, math.floor(most / step)))

    def begin(self) -> None:
        self.turns = 0

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        if self.turns == 0 and info["collided"]:
            self.turns = int(self.rng.integers(self.least, self.most + 1))
            self.direction = LEFT if self.rng.random() < 0.5 else RIGHT
        elif self.turns == 0:
            return FORWARD
        self.turns -= 1
        return self.direction
