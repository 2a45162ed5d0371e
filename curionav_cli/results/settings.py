"""Settings of what a run measures of itself, beside its coverage."""

from __future__ import annotations

from dataclasses import dataclass

from curionav_cli.bounds import bounded


@dataclass(frozen=True)
class Results:
    """probe_every: episodes between two measurements of the world model on the building's probe; 0 for none.

    Of curionav train it counts saves, one every 100 iterations.
    """

    probe_every: int = 0

    def __post_init__(self) -> None:
        bounded("results", self, {"probe_every": (0, 10**6)})
