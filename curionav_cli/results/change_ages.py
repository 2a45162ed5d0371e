"""Whether a model comes to know what moved: surprise near it by the age of the move, with changes less without.

Paired by seed, so that what is only special about the place goes out. An age of three episodes is at most three visits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from curionav_cli.results.change_pairs import Pair, in_groups
from curionav_cli.results.changes import ELSEWHERE, Seen, relative, written
from curionav_cli.results.statistics import Estimate, mean_interval
from curionav_cli.results.tables import Columns, Row

VISITS = 3
FEWEST = 3  # pairs
COLUMNS: Columns = (
    ("env", "env", "{}"), ("agent", "agent", "{}"), ("episodes since the move", "age", "{}"), ("pairs", "n", "{:,}"),
    ("surprise there, of elsewhere, on", "on", "{:.2f}"), ("off", "off", "{:.2f}"), ("on less off", "less", "{:+.2f}"),
    ("known within three visits", "known", "{}"))
BELOW = (
    "Surprise near what moved, of that elsewhere in the same episode, with changes (on) and at the same places without "
    "(off): means over runs of their means over episodes; on less off paired by seed, with its 95 % t interval. There "
    "is something to know if it lies above zero in the episode after the move; it is known if from an age of at most "
    f"{VISITS} on no interval lies above zero. Ages of fewer than {FEWEST} pairs decide nothing.")


def rows(found: Sequence[Seen]) -> list[Row]:
    """A row for each agent and age of a move, youngest first; the first of an agent says whether it is known."""
    return [row for env, agent, pairs in in_groups(found) for row in group(env, agent, pairs)]


def group(env: str, agent: str, pairs: Sequence[Pair]) -> list[Row]:
    """The rows of one agent in one world; none without predictions in both runs of a pair."""
    sides = [(by_age(on, episodes), by_age(off, episodes)) for on, off, episodes in pairs]
    made: list[Row] = []
    less: dict[int, Estimate] = {}
    for age in sorted({age for on, off in sides for age in on.keys() & off.keys()} - {ELSEWHERE}):
        both = np.array([(on[age], off[age]) for on, off in sides if age in on and age in off])
        estimate = mean_interval(both[:, 0] - both[:, 1])
        if len(both) >= FEWEST:
            less[age] = estimate
        made.append({"env": env, "agent": agent, "age": written(age), "n": len(both), "on": float(both[:, 0].mean()),
                     "off": float(both[:, 1].mean()), "less": estimate})
    return [{**row, "known": known(less)} if row is made[0] else row for row in made]


def by_age(one: Seen, episodes: int) -> dict[int, float]:
    """Mean relative surprise of each age in a run's first episodes."""
    ratios = relative(kl for index, kl in one.kl.items() if index < episodes)
    return {age: float(np.mean(each)) for age, each in ratios.items() if each}


def known(less: Mapping[int, Estimate]) -> str:
    """Whether what moved is known within VISITS. less: surprise on less off, by age."""
    if 0 not in less:
        return f"fewer than {FEWEST} pairs: not decided"
    high = [age for age, estimate in less.items() if estimate.low > 0]
    if 0 not in high:
        return "not tested: no surprise at what just moved"
    if max(high) >= VISITS:
        return "no"
    return "yes" if max(less) > max(high) else "no older moves: not decided"
