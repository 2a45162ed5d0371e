"""Rows of a comparison: what each arm reached, by how much arms differ, and how uncertain it is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from curionav_cli.results import statistics
from curionav_cli.results.comparison.comparison import Comparison, measures
from curionav_cli.results.statistics import Estimate, mean_interval
from curionav_cli.results.tables import Row

ALL = "all"
ENOUGH = 5  # seeds: below, an interval is hardly worth its name


def run_rows(comparison: Comparison, at: Sequence[int]) -> Iterator[Row]:
    """Make a row for each run, those that were left out included, with its measures where it was compared."""
    horizons = {field.env: field.horizon for field in comparison.fields}
    for run, (env, arm) in comparison.names.items():
        out = comparison.left_out.get(run, "")
        compared = {} if out else {"compared_steps": horizons[env], **measures(run, horizons[env], at)}
        yield {"env": env, "arm": arm, "seed": run.seed, "state": run.state, "steps": run.steps, **compared,
               "left_out": out, "gaps": "; ".join(run.gaps), "error": run.error, "folder": str(run.folder)}


class Reached(NamedTuple):
    """The median number of steps to a share of the cells, None unless more than half arrived; how many of n did."""

    steps: float | None
    runs: int
    n: int

    def __format__(self, form: str) -> str:
        """'{:,.0f}' gives 1,250 (4/5)."""
        return f"{'-' if self.steps is None else format(self.steps, form)} ({self.runs}/{self.n})"


def arm_rows(comparison: Comparison, at: Sequence[int]) -> Iterator[Row]:
    """Make a row for each arm in each environment."""
    for field in comparison.fields:
        for arm, runs in field.arms.items():
            rows = [measures(run, field.horizon, at) for run in runs]
            yield {"env": field.env, "arm": arm, "n": len(runs), "steps": field.horizon,
                   **{key: summary(key, [row[key] for row in rows]) for key in rows[0]}}


def summary(key: str, values: list[float | None]) -> Any:
    """Mean and interval of a measure; of a cost the mean, where all are known; of steps the median, as Reached."""
    known = np.array([np.inf if value is None else value for value in values])
    if key.startswith(("coverage", "area")):
        return mean_interval(known)
    middle = float(np.median(known) if key.startswith("steps_to") else np.mean(known))
    number = middle if np.isfinite(middle) else None
    return Reached(number, int(np.isfinite(known).sum()), len(values)) if key.startswith("steps_to") else number


def pair_rows(comparison: Comparison, baseline: str | None, rng: np.random.Generator) -> Iterator[Row]:
    """Paired differences of the area: every two arms, or all others minus the baseline; then over all environments."""
    for field in comparison.fields:
        for ours, theirs in pairs(list(field.arms), baseline):
            difference = field.difference(ours, theirs)
            if len(difference):
                yield {"env": field.env, "arm": ours, "minus": theirs, "n": len(difference), "steps": field.horizon,
                       "difference": mean_interval(difference),
                       "p": statistics.sign_flip_test(difference, rng)}
    for ours, theirs in pairs(list(comparison.arms), baseline):
        strata = [field.difference(ours, theirs) for field in comparison.common]
        if strata and all(map(len, strata)):
            scores = [[field.scores(arm) for field in comparison.common] for arm in (ours, theirs)]
            chance = statistics.improvement(scores[0], scores[1], rng)
            yield {"env": ALL, "arm": ours, "minus": theirs, "n": sum(map(len, strata)), "improvement": chance,
                   "difference": statistics.mean_of_means(strata),
                   "p": statistics.sign_flip_test(np.concatenate(strata), rng)}


def pairs(arms: list[str], baseline: str | None) -> list[tuple[str, str]]:
    """Pairs (ours, theirs): every two arms in order of appearance, or every other one beside the baseline."""
    if baseline is None:
        return list(combinations(arms, 2))
    return [(arm, baseline) for arm in arms if arm != baseline] if baseline in arms else []


def overall_rows(comparison: Comparison, rng: np.random.Generator) -> Iterator[Row]:
    """The interquartile mean of every arm over the runs of all environments that every arm has runs in."""
    for arm in comparison.arms if comparison.common else ():
        strata = [field.scores(arm) for field in comparison.common]
        yield {"arm": arm, "n": sum(map(len, strata)), "environments": len(strata),
               "interquartile_mean": statistics.interquartile_interval(strata, rng)}


def profiles(comparison: Comparison, thresholds: np.ndarray, rng: np.random.Generator) -> dict[str, Estimate]:
    """The performance profile of every arm over the same runs. thresholds: (K,)."""
    return {arm: statistics.performance_profile([field.scores(arm) for field in comparison.common], thresholds, rng)
            for arm in comparison.arms if comparison.common}


def notes(comparison: Comparison, baseline: str | None) -> Iterator[str]:
    """Caveats for a reader of the numbers, a line each."""
    for run, why in comparison.left_out.items():
        env, arm = comparison.names[run]
        yield f"LEFT OUT: {env}, {arm}, seed {run.seed} ({run.state}): {why}. {run.folder} {run.error}".rstrip()
    for run in comparison.names:
        yield from (f"GAP: {gap}" for gap in run.gaps)
        if run not in comparison.left_out and run.state != "done":
            env, arm = comparison.names[run]
            yield f"Not finished ({run.state}), but long enough: {env}, {arm}, seed {run.seed}. {run.error}".rstrip()
    for field in comparison.fields:
        longest = max(run.steps for run, (env, _) in comparison.names.items() if env == field.env)
        if longest > field.horizon:
            yield (f"{field.env}: compared up to {field.horizon:,} steps, which every run has; the longest has "
                   f"{longest:,}.")
    few = [f"{arm} in {field.env} ({len(runs)})" for field in comparison.fields for arm, runs in field.arms.items()
           if len(runs) < ENOUGH]
    if few:
        yield f"WARNING: fewer than {ENOUGH} seeds, so that the intervals say little: {', '.join(few)}."
    for field in comparison.fields:
        for ours, theirs in pairs(list(field.arms), baseline):
            difference = field.difference(ours, theirs)
            if not len(difference):
                yield f"{field.env}: {ours} and {theirs} share no seed, so there is no paired difference."
            elif not difference.any():
                yield f"{field.env}: {ours} and {theirs} covered the same in every shared seed."
    missing = [field.env for field in comparison.fields if field not in comparison.common]
    if missing:
        yield f"Not every arm has runs in {', '.join(missing)}: " + (
            "left out of what is said over all runs." if comparison.common else "nothing is said over all runs.")
