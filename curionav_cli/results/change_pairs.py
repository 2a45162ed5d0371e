"""What change costs: runs with changes less those of the same agent and seed without, as far as both go.

Coverage counts all cells of the floor, because what can be visited differs with and without changes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from curionav_cli.results.changes import Seen, relative
from curionav_cli.results.statistics import Estimate, mean_interval
from curionav_cli.results.tables import Columns, Row

COST = 3.0  # points of the floor within which a difference counts as none
COLUMNS: Columns = (
    ("env", "env", "{}"), ("agent", "agent", "{}"), ("pairs", "n", "{:,}"), ("steps", "steps", "{:,}"),
    ("coverage of the floor, on", "coverage_on", "{:.1%}"), ("coverage, off", "coverage_off", "{:.1%}"),
    ("on less off, points", "coverage", "{:+.1f}"), ("of the area", "area", "{:+.4f}"),
    ("steps near what just moved, on", "near_on", "{:.1%}"), ("near, off", "near_off", "{:.1%}"),
    ("surprise there, of elsewhere, on", "fresh_on", "{:.2f}"), ("surprise, off", "fresh_off", "{:.2f}"),
    ("on less off", "fresh", "{:+.2f}"), ("does change cost coverage", "cost", "{}"))
BELOW = (
    "Runs with changes (on) less those of the same agent and seed without (off), up to the end of the shorter one; "
    "means over pairs, differences with 95 % t intervals. off is asked about the places where things stand in on. "
    f"Change costs coverage where the interval lies below zero, and does not where it lies within {COST:g} points.")


class Part(NamedTuple):
    """What a run did in its first steps: shares, and surprise near what just moved over that elsewhere, or nan."""

    coverage: float
    area: float
    near: float
    fresh: float


class Pair(NamedTuple):
    """A run with changes, one without of the same agent and seed, and how many episodes both have."""

    on: Seen
    off: Seen
    episodes: int


def in_groups(found: Sequence[Seen]) -> Iterator[tuple[str, str, list[Pair]]]:
    """World, agent and pairs of each agent that has runs with and without changes of the same world and seed."""
    for env, agent in dict.fromkeys((one.run.config["env"]["name"], one.run.agent) for one in found):
        here = [one for one in found if (one.run.config["env"]["name"], one.run.agent) == (env, agent)]
        on, off = ({one.run.seed: one for one in here if one.changing == changing} for changing in (True, False))
        pairs = [Pair(on[seed], off[seed], min(len(on[seed].age), len(off[seed].age))) for seed in on if seed in off]
        if pairs:
            yield env, agent, pairs


def rows(found: Sequence[Seen]) -> list[Row]:
    """A row for each agent that has a pair of runs."""
    return [row(env, agent, pairs) for env, agent, pairs in in_groups(found)]


def row(env: str, agent: str, pairs: Sequence[Pair]) -> Row:
    """The row of one agent in one world."""
    steps = [min(sum(len(age) - 1 for age in one.age[:end]) for one in (on, off)) for on, off, end in pairs]
    parts = [[part(one, pair.episodes, until) for one in (pair.on, pair.off)] for pair, until in zip(pairs, steps)]
    return {"env": env, "agent": agent, "n": len(pairs), "steps": min(steps), **means(np.array(parts))}


def part(one: Seen, episodes: int, steps: int) -> Part:
    """What a run did in its first episodes, of so many steps."""
    near = float(np.concatenate([age[1:] == 0 for age in one.age[:episodes]]).mean())
    fresh = relative(kl for index, kl in one.kl.items() if index < episodes)[0]
    return Part(int(one.run.curve.at(steps)) / one.run.curve.cells, one.run.curve.until(steps).area() or 0.0, near,
                float(np.mean(fresh)) if fresh else np.nan)


def means(parts: np.ndarray) -> Mapping[str, object]:
    """Means of what runs with and without changes did, and of the differences. parts: (pairs, 2, 4)."""
    on, off = (dict(zip(Part._fields, half)) for half in parts.mean(0))
    less: dict[str, Estimate] = {name: mean_interval(column) for name, column in zip(Part._fields, (
        parts[:, 0] - parts[:, 1]).T)}
    points = Estimate(*(100 * bound for bound in less["coverage"]))
    sides = {f"{name}_{side}": float(half[name]) for name in ("coverage", "near", "fresh")
             for side, half in (("on", on), ("off", off)) if not np.isnan(half[name])}
    fresh = {"fresh": less["fresh"]} if not np.isnan(less["fresh"].value) else {}
    return {**sides, "coverage": points, "area": less["area"], **fresh, "cost": cost(points)}


def cost(points: Estimate) -> str:
    """Whether change costs coverage. points: of the floor, on less off."""
    if np.isnan(points.low):
        return "one pair: not decided"
    if points.high < 0:
        return "yes"
    return "no" if points.low >= -COST and points.high <= COST else "no, it adds" if points.low > 0 else "not decided"
