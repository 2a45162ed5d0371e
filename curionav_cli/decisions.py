"""Where in an episode an agent chose, and what: read from the primitive actions that the episode holds.

A choice takes one step, or several: an action that is held (`Steps`), or an option (options.py). Whoever learns from an
episode needs the frames at which a choice was made, and the choices.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from curionav_cli.errors import RunFolderError


class Decisions(NamedTuple):
    """The n choices in an episode of T steps; a choice that the episode's end cut off is not among them.

    frame (n+1,) int64: the frames at which they were made, then the one at which the last had been carried out.
    action (n,) int64: what was chosen, as an index into `Every.names`.
    """

    frame: np.ndarray
    action: np.ndarray


class Execution(Protocol):
    """Carries out one choice after another, as primitive actions."""

    def begin(self) -> None:
        """Forget the last episode: a choice is due."""

    def due(self, info: dict[str, Any]) -> bool:
        """Whether the last choice is carried out, so that another is due; info: after the last step."""

    def start(self, choice: int) -> None:
        """Begin to carry out a choice."""

    def step(self) -> int:
        """The primitive action of the next step."""


class Every(Protocol):
    """How often an agent chooses, and among what.

    names: of the choices. most: steps that one takes at most. held: steps that each takes; 0 where they differ.
    unit, lasting: what choices are called in messages, and how long they last.
    """

    @property
    def names(self) -> tuple[str, ...]: ...

    @property
    def most(self) -> int: ...

    @property
    def held(self) -> int: ...

    @property
    def unit(self) -> str: ...

    @property
    def lasting(self) -> str: ...

    def execution(self) -> Execution:
        """What carries out the choices while acting."""

    def decisions(self, action: np.ndarray, collided: np.ndarray, what: object = "an episode") -> Decisions:
        """Read the choices from primitive actions (T,) and collided (T,); what: the episode, for the message.

        Raises RunFolderError where the episode was not recorded with such choices.
        """


@dataclass(frozen=True)
class Steps:
    """One of the three primitive actions, held for `held` steps (action repeat)."""

    held: int = 1
    names = ("forward", "left", "right")  # constants.ACTIONS

    @property
    def most(self) -> int:
        return self.held

    @property
    def unit(self) -> str:
        return "actions" if self.held == 1 else f"actions held for {self.held} steps"

    @property
    def lasting(self) -> str:
        return f"actions are held for {self.held} (agent.action_repeat)"

    def execution(self) -> Execution:
        return Hold(self.held)

    def decisions(self, action: np.ndarray, collided: np.ndarray, what: object = "an episode") -> Decisions:
        count = len(action) // self.held
        groups = action[:count * self.held].reshape(-1, self.held)
        if (groups != groups[:, :1]).any():
            raise RunFolderError(f"{what} was recorded without agent.action_repeat={self.held}: its actions are not "
                                 f"held for {self.held} steps. Set agent.action_repeat=1.")
        return Decisions(np.arange(count + 1) * self.held, groups[:, 0].copy())


EACH_STEP = Steps()


class Hold:
    """Repeats an action for a number of steps (Execution)."""

    def __init__(self, steps: int):
        self.steps = steps
        self.begin()

    def begin(self) -> None:
        self.left = 0

    def due(self, info: dict[str, Any]) -> bool:
        return self.left == 0

    def start(self, choice: int) -> None:
        self.action, self.left = choice, self.steps

    def step(self) -> int:
        self.left -= 1
        return self.action
