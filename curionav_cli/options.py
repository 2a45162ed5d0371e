"""Options: actions that last several steps (Sutton, Precup and Singh, 1999, section 3).

An option turns by one of seven angles, 0, +-30, +-60 or +-90 degrees, in primitive turns of 10 degrees, then drives
forward until a move is cut short or cancelled, or until MOVES moves are made. At least one move is tried, so that an
option is a run of turns one way and a run of moves: the primitive actions and `collided` of an episode tell uniquely
which options were chosen, and where. Episodes on disk look the same with and without options.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from curionav_cli.constants import FORWARD, LEFT, RIGHT, OptionSet
from curionav_cli.decisions import Decisions, Every, Execution, Steps
from curionav_cli.errors import RunFolderError

SEVEN = (0, 3, -3, 6, -6, 9, -9)  # primitive turns, left positive
MOVES = 8  # at most, two metres
NOT_OPTIONS = "{} was recorded without agent.options=seven: its actions up to step {} are no options. " \
              "Set agent.options=none."


@dataclass(frozen=True)
class Options:
    """The seven options (decisions.Every)."""

    names = tuple(f"{'left' if turns > 0 else 'right'}_{10 * abs(turns)}" if turns else "ahead" for turns in SEVEN)
    most = max(SEVEN) + MOVES
    held = 0
    unit = "options"
    lasting = f"options take up to {most} (agent.options)"

    def execution(self) -> Execution:
        return TurnAndDrive()

    def decisions(self, action: np.ndarray, collided: np.ndarray, what: object = "an episode") -> Decisions:
        frame, chosen = [0], []
        turned = moves = 0
        for end, (move, blocked) in enumerate(zip(action.tolist(), collided.tolist(), strict=True), 1):
            if move == FORWARD:
                moves += 1
            else:
                turned += 1 if move == LEFT else -1
            if abs(turned) + moves != end - frame[-1] or abs(turned) > max(SEVEN) or \
                    (moves and (move != FORWARD or turned not in SEVEN)):
                raise RunFolderError(NOT_OPTIONS.format(what, end))
            if moves and (blocked or moves == MOVES):
                frame.append(end)
                chosen.append(SEVEN.index(turned))
                turned = moves = 0
        return Decisions(np.array(frame, np.int64), np.array(chosen, np.int64))


class TurnAndDrive:
    """Carries out options (decisions.Execution)."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        self.turns = self.moves = 0

    def due(self, info: dict[str, Any]) -> bool:
        return self.moves == 0 or (self.moves < MOVES and bool(info["collided"]))

    def start(self, choice: int) -> None:
        self.turns, self.moves = SEVEN[choice], MOVES

    def step(self) -> int:
        if self.turns == 0:
            self.moves -= 1
            return FORWARD
        direction = LEFT if self.turns > 0 else RIGHT
        self.turns += -1 if self.turns > 0 else 1
        return direction


def chosen(agent: Mapping[str, Any]) -> Every:
    """How often an agent of these settings chooses: by agent.options, then agent.action_repeat, else at each step."""
    none = agent.get("options", OptionSet.none) in (OptionSet.none, OptionSet.none.value)
    return Steps(agent.get("action_repeat", 1)) if none else Options()
