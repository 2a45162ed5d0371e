"""Settings of the agents that do not learn; their values stand in conf/agent."""

from __future__ import annotations

from dataclasses import dataclass

from curionav_cli.bounds import within
from curionav_cli.constants import OptionSet


@dataclass(frozen=True)
class Random:
    """Each action, or each option, with the same probability."""

    name: str
    options: OptionSet


@dataclass(frozen=True)
class Sticky:
    """Repeats its last action with probability `repeat`."""

    name: str
    repeat: float

    def __post_init__(self) -> None:
        within("agent.repeat", self.repeat, least=0, most=1)


@dataclass(frozen=True)
class Bounce:
    """Goes forward until blocked, then turns left or right by an angle drawn from [min_turn, max_turn] degrees."""

    name: str
    min_turn: float
    max_turn: float

    def __post_init__(self) -> None:
        within("agent.min_turn", self.min_turn, least=10, most=180)
        within("agent.max_turn", self.max_turn, least=self.min_turn, most=180)


@dataclass(frozen=True)
class Frontier:
    """Oracle with map access: takes the shortest way to the nearest cell that it has not visited."""

    name: str
