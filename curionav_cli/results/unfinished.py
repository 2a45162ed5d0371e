"""What can be said of runs that were cut, or declared and not given: between which bounds their numbers must end.

Coverage never falls, and a step adds one cell at most.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import NamedTuple

import numpy as np

from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.summary_file import opened
from curionav_cli.results.tables import percent

NEAR, FAR = 5.0, 15.0  # metres from the dock
UNDECIDED = "not decided"

Runs = Mapping[int | str, RunSummary | None]  # by seed; None of one that was declared and not given


class Bounds(NamedTuple):
    """The lowest and the highest that a number can still be; the same where nothing is missing."""

    low: float
    high: float

    def less(self, other: Bounds) -> Bounds:
        """Bounds of the difference of two shares."""
        return Bounds(round(self.low - other.high, 12), round(self.high - other.low, 12))

    def verdict(self, least: float, most: float = np.inf) -> str:
        """Whether the number is within least and most."""
        if least <= self.low and self.high <= most:
            return "seen"
        return "not seen" if self.high < least or self.low > most else UNDECIDED

    def written(self, form: str) -> str:
        low, high = (percent(part) if form == ".1%" else f"{part:{form}}" for part in self)
        return low if low == high else f"{low} to {high}".replace("to inf", "or more")


UNKNOWN = Bounds(0.0, 1.0)  # the coverage of a run that was not given


def given(runs: Runs) -> dict[int | str, RunSummary]:
    """The runs that there are."""
    return {seed: run for seed, run in runs.items() if run is not None}


def covered(run: RunSummary | None, steps: int) -> Bounds:
    """What a run covers, or could still, in so many steps."""
    if run is None:
        return UNKNOWN
    found, ahead = int(run.curve.at(min(steps, run.steps))), max(0, steps - run.steps)
    return Bounds(found / run.curve.cells, min(1.0, (found + ahead) / run.curve.cells))


def reached(runs: Runs, steps: int) -> list[float]:
    """What each of the given runs covered in so many steps, or until its end."""
    return [covered(run, steps).low for run in given(runs).values()]


def mean(runs: Runs, steps: int) -> Bounds:
    """Mean coverage of runs."""
    each = [covered(run, steps) for run in runs.values()]
    return Bounds(*map(float, np.mean(each, axis=0))) if each else UNKNOWN


def most(bounds: Iterable[Bounds]) -> Bounds:
    """The largest of some numbers."""
    return Bounds(*map(max, zip(*bounds)))


def near_dock(runs: Runs, steps: int) -> tuple[float, Bounds]:
    """Mean visits of a visitable cell near the dock over those of one far from it, in all runs together; and bounds.

    All that is missing could be far from the dock, or near it (an episode's first pose counts too: two a step at most).
    """
    ahead = sum(steps if run is None else max(0, steps - run.steps) for run in runs.values())
    counts = np.array([visits(run) for run in given(runs).values()] or [(0, 1, 0, 1)], float)
    near_cells, far_cells = counts[0, 1::2].clip(1)
    near, far = counts[:, 0].sum() / near_cells, counts[:, 2].sum() / far_cells
    with np.errstate(divide="ignore", invalid="ignore"):
        now, low, high = np.array([near, near, near + 2 * ahead / near_cells]) / np.array(
            [far, far + ahead / far_cells, far])
    return float(now), Bounds(float(low), float(high))


@cache
def visits(run: RunSummary) -> tuple[int, int, int, int]:
    """Visits within NEAR of the dock and the visitable cells there; the same beyond FAR."""
    counted = opened(run.folder).coverage
    away = counted.plan.away(counted.plan.dock or counted.plan.start)
    near, far = (counted.plan.visitable & where for where in (away <= NEAR, away > FAR))
    return int(counted.visits[near].sum()), int(near.sum()), int(counted.visits[far].sum()), int(far.sum())
