"""The settings of each agent, as schema.py describes it; the values stand in conf/agent and conf/scale."""

from __future__ import annotations

from dataclasses import dataclass

from curionav_cli.bounds import within


@dataclass(frozen=True)
class Random:
    """Each action equally likely."""

    name: str


@dataclass(frozen=True)
class Sticky:
    """Repeats its last action with probability `repeat`."""

    name: str
    repeat: float

    def __post_init__(self) -> None:
        within("agent.repeat", self.repeat, least=0, most=1)


@dataclass(frozen=True)
class Bounce:
    """Forward until blocked, then a turn drawn from [min_turn, max_turn] degrees, either way."""

    name: str
    min_turn: float
    max_turn: float

    def __post_init__(self) -> None:
        within("agent.min_turn", self.min_turn, least=10, most=180)
        within("agent.max_turn", self.max_turn, least=self.min_turn, most=180)


@dataclass(frozen=True)
class Frontier:
    """The oracle: is told the map, walks to the nearest cell it has not visited."""

    name: str
