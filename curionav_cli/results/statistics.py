"""Estimates over runs and their uncertainty. Arrays in, numbers out; nothing is read or drawn here.

Per environment: the mean and Student's t interval, which holds from three seeds on, where a bootstrap does not.
Over seeds x environments: the interquartile mean, the probability of improvement and the performance profile, with
the percentile interval of a stratified bootstrap (Agarwal et al. 2021, "Deep Reinforcement Learning at the Edge of
the Statistical Precipice", sections 4.1 to 4.3). Between two arms that share seeds: the mean difference with its t
interval, and Fisher's sign-flip test.

Letters. A stratum is what one arm scored in one environment, (n_s,) floats; R draws of the bootstrap; K thresholds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

from curionav_cli.results.tables import written

LEVEL = 0.95
EXACT = 16  # pairs: up to so many every assignment of signs is tried

Strata = Sequence[np.ndarray]


class Estimate(NamedTuple):
    """A number and its interval, floats or arrays of one shape; the bounds are nan where there is one run only."""

    value: float | np.ndarray
    low: float | np.ndarray
    high: float | np.ndarray

    def __format__(self, form: str) -> str:
        """'{:.1%}' gives 45.4% [40.1, 50.7]."""
        value, low, high = (written(f"{{:{form}}}", part) for part in self)
        return value if np.isnan(self.low) else f"{value} [{low.rstrip('%')}, {high.rstrip('%')}]"


def mean_interval(values: np.ndarray) -> Estimate:
    """Mean over the first axis and its t interval. values: (n, ...)."""
    n, mean = len(values), np.mean(values, axis=0)
    if n < 2:
        return Estimate(mean, np.full_like(mean, np.nan), np.full_like(mean, np.nan))
    half = stats.t.ppf((1 + LEVEL) / 2, n - 1) * np.std(values, axis=0, ddof=1) / np.sqrt(n)
    return Estimate(mean, mean - half, mean + half)


def share_interval(count: int, n: int) -> Estimate:
    """Share of n trials and Wilson's score interval, which stays within 0 and 1 (Wilson 1927); nan without a trial."""
    if not n:
        return Estimate(np.nan, np.nan, np.nan)
    return Estimate(count / n, *stats.binomtest(count, n).proportion_ci(LEVEL, method="wilson"))


def mean_of_means(strata: Strata) -> Estimate:
    """Mean of the strata's means, and its t interval with the degrees of freedom of Welch and Satterthwaite."""
    value = float(np.mean([runs.mean() for runs in strata]))
    if min(map(len, strata)) < 2:
        return Estimate(value, np.nan, np.nan)
    parts = np.array([runs.var(ddof=1) / len(runs) for runs in strata]) / len(strata) ** 2
    if not parts.any():
        return Estimate(value, value, value)
    freedom = parts.sum() ** 2 / sum(part ** 2 / (len(runs) - 1) for part, runs in zip(parts, strata))
    half = float(stats.t.ppf((1 + LEVEL) / 2, freedom) * np.sqrt(parts.sum()))
    return Estimate(value, value - half, value + half)


def sign_flip_test(difference: np.ndarray, rng: np.random.Generator, draws: int = 100_000) -> float:
    """Two-sided p of the sign-flip test: how often random signs make |mean| as large as it is. difference: (n,).

    Exact up to 16 pairs; the smallest p is then 2 / 2^n. For more pairs by Monte Carlo, counting the data as one
    of the draws (Phipson and Smyth 2010). Not scipy's permutation_test: it gives the same p, but takes 2 s for 16 pairs
    (this 0.1 s) and refuses a single one.
    """
    n = len(difference)
    enough = abs(difference.sum()) - 1e-12 * np.abs(difference).sum()
    if n <= EXACT:
        flipped = np.arange(2 ** n)[:, None] >> np.arange(n) & 1
        return float(np.mean(np.abs((1 - 2 * flipped) @ difference) >= enough))
    sums = np.abs((1 - 2 * rng.integers(0, 2, (draws, n), np.int8)) @ difference)
    return float((1 + (sums >= enough).sum()) / (1 + draws))


def interquartile_mean(runs: np.ndarray) -> np.ndarray:
    """Mean of the middle half along the last axis: a quarter of the runs is cut off at each end, rounded down:
    of fewer than four none is. runs: (..., N)."""
    return stats.trim_mean(runs, 0.25, axis=-1)


def resampled(strata: Strata, rng: np.random.Generator, draws: int) -> list[np.ndarray]:
    """Each stratum drawn again from itself with replacement: (R, n_s) each."""
    return [runs[rng.integers(0, len(runs), (draws, len(runs)))] for runs in strata]


def percentiles(value: float | np.ndarray, samples: np.ndarray) -> Estimate:
    """`value` with the percentile interval of its bootstrap. samples: (R, ...)."""
    return Estimate(value, *np.quantile(samples, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0))


def interquartile_interval(strata: Strata, rng: np.random.Generator, draws: int = 10_000) -> Estimate:
    """Interquartile mean of all runs, each of the same weight, and its bootstrap interval."""
    samples = interquartile_mean(np.concatenate(resampled(strata, rng, draws), axis=1))
    return percentiles(float(interquartile_mean(np.concatenate(strata))), samples)


def chance(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """Probability that a run of ours beats one of theirs, ties counting half (Mann and Whitney's U / (m n)).

    ours: (..., m), theirs: (..., n); result: (...).
    """
    more = ours[..., :, None] > theirs[..., None, :]
    same = ours[..., :, None] == theirs[..., None, :]
    return np.asarray(more.mean((-2, -1)) + same.mean((-2, -1)) / 2)


def improvement(ours: Strata, theirs: Strata, rng: np.random.Generator, draws: int = 10_000) -> Estimate:
    """Probability of improvement, averaged over environments: the same ones on both sides, in one order."""
    assert len(ours) == len(theirs), (len(ours), len(theirs))
    value = np.mean([chance(x, y) for x, y in zip(ours, theirs)])
    drawn = zip(resampled(ours, rng, draws), resampled(theirs, rng, draws))
    return percentiles(float(value), np.mean([chance(x, y) for x, y in drawn], axis=0))


def performance_profile(strata: Strata, thresholds: np.ndarray, rng: np.random.Generator,
                        draws: int = 2_000) -> Estimate:
    """Share of all runs that score above each threshold. thresholds: (K,); result: (K,) each."""
    samples = [(runs[..., None] > thresholds).mean(1)
               for runs in np.array_split(np.concatenate(resampled(strata, rng, draws), axis=1), 20)]
    value = (np.concatenate(strata)[:, None] > thresholds).mean(0)
    return percentiles(value, np.concatenate(samples))
