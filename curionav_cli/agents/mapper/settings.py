"""The settings of the mapping explorer; the values stand in conf/agent/mapper.yaml."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from curionav_cli.bounds import bounded


class Goal(Enum):
    """The nearest cell not visited, the nearest frontier, or the frontier that shows most for a metre of the way."""

    unvisited = "unvisited"
    frontier = "frontier"
    information = "information"


@dataclass(frozen=True)
class Mapper:
    """Frontier-based exploration on the robot's own map, from depth and pose; no learning, no privileges."""

    name: str
    goal: Goal
    reach: float  # metres of a view that are entered into the map

    def __post_init__(self) -> None:
        bounded("agent", self, {"reach": (0.5, 10.0)})
