"""Estimates against scipy, brute force, and stored figures of rliable 1.2.0 (arch 7.2.0, scipy 1.17.1)."""

import itertools

import numpy as np
import pytest
from scipy import stats

from curionav_cli.results import statistics
from curionav_cli.results.statistics import Estimate

# Runs x environments, as rliable takes them.
OURS = np.array([[0.31, 0.62, 0.11], [0.35, 0.55, 0.14], [0.29, 0.71, 0.08], [0.44, 0.58, 0.12], [0.38, 0.66, 0.17]])
THEIRS = np.array([[0.28, 0.60, 0.13], [0.30, 0.41, 0.09], [0.33, 0.52, 0.08], [0.27, 0.49, 0.15], [0.36, 0.55, 0.12]])
THRESHOLDS = np.array([0.1, 0.125, 0.3, 0.33, 0.5, 0.6])

# What rliable made of them: aggregate_iqm and get_interval_estimates with 50000 draws ...
IQM = {"ours": (0.35666667, 0.33000000, 0.38777778), "theirs": (0.30222222, 0.28111111, 0.32777778)}
# ... probability_of_improvement with 20000, and create_performance_profile with 20000.
IMPROVEMENT = (0.74, 0.56, 0.90)
PROFILE = ([14 / 15, 12 / 15, 9 / 15, 8 / 15, 5 / 15, 3 / 15],
           [12 / 15, 10 / 15, 7 / 15, 6 / 15, 5 / 15, 1 / 15], [1, 14 / 15, 10 / 15, 10 / 15, 5 / 15, 5 / 15])


@pytest.fixture
def rng():
    return np.random.default_rng(0)


@pytest.mark.parametrize(("name", "runs"), [("ours", OURS), ("theirs", THEIRS)])
def test_the_interquartile_mean_is_that_of_rliable(rng, name, runs):
    estimate = statistics.interquartile_interval(list(runs.T), rng)
    assert estimate.value == pytest.approx(IQM[name][0], abs=1e-8)
    assert (estimate.low, estimate.high) == pytest.approx(IQM[name][1:], abs=2e-3)


def test_the_probability_of_improvement_is_that_of_rliable(rng):
    estimate = statistics.improvement(list(OURS.T), list(THEIRS.T), rng)
    assert estimate.value == pytest.approx(IMPROVEMENT[0], abs=1e-12)
    assert (estimate.low, estimate.high) == pytest.approx(IMPROVEMENT[1:], abs=0.015)
    u = [stats.mannwhitneyu(x, y).statistic / (len(x) * len(y)) for x, y in zip(OURS.T, THEIRS.T)]
    assert estimate.value == pytest.approx(np.mean(u))


def test_the_performance_profile_is_that_of_rliable(rng):
    estimate = statistics.performance_profile(list(OURS.T), THRESHOLDS, rng)
    for ours, theirs in zip(estimate, PROFILE):
        np.testing.assert_allclose(ours, theirs, atol=1e-12)


def test_environments_may_have_different_numbers_of_seeds(rng):
    strata = [OURS[:, 0], OURS[:3, 1]]
    pooled = sorted([*OURS[:, 0], *OURS[:3, 1]])
    estimate = statistics.interquartile_interval(strata, rng)
    assert estimate.value == pytest.approx(np.mean(pooled[2:6])) and estimate.low < estimate.value < estimate.high
    assert [drawn.shape for drawn in statistics.resampled(strata, rng, 7)] == [(7, 5), (7, 3)]
    assert all(set(drawn.ravel()) <= set(runs) for drawn, runs in
               zip(statistics.resampled(strata, rng, 7), strata))


def test_the_same_generator_gives_the_same_interval():
    one, other = (statistics.interquartile_interval(list(OURS.T), np.random.default_rng(3)) for _ in range(2))
    assert one == other


def test_the_mean_interval_is_that_of_scipy():
    estimate = statistics.mean_interval(OURS[:, 0])
    reference = stats.ttest_1samp(OURS[:, 0], 0).confidence_interval(0.95)
    assert estimate.value == pytest.approx(OURS[:, 0].mean())
    assert (estimate.low, estimate.high) == pytest.approx((reference.low, reference.high))
    curves = statistics.mean_interval(OURS)
    assert curves.low.shape == (3,) and curves.low[0] == pytest.approx(estimate.low)


def test_one_run_has_no_interval():
    estimate = statistics.mean_interval(np.array([0.4]))
    assert estimate.value == 0.4 and np.isnan(estimate.low) and np.isnan(estimate.high)
    assert f"{estimate:.1f}" == "0.4" and f"{Estimate(0.5, 0.25, 0.75):.0%}" == "50% [25, 75]"


def test_the_paired_difference_is_that_of_scipy():
    estimate = statistics.mean_interval(OURS[:, 1] - THEIRS[:, 1])
    reference = stats.ttest_rel(OURS[:, 1], THEIRS[:, 1]).confidence_interval(0.95)
    assert (estimate.low, estimate.high) == pytest.approx((reference.low, reference.high))


def test_the_mean_over_environments_is_welchs_with_two_of_them(rng):
    x, y = rng.normal(0.4, 0.1, 5), rng.normal(0.1, 0.02, 4)
    estimate = statistics.mean_of_means([x, y])
    reference = stats.ttest_ind(x, -y, equal_var=False).confidence_interval(0.95)  # of mean(x) + mean(y)
    assert (estimate.low, estimate.high) == pytest.approx((reference.low / 2, reference.high / 2))
    assert statistics.mean_of_means([x]) == pytest.approx(statistics.mean_interval(x))
    assert statistics.mean_of_means([np.full(3, 0.5), np.full(2, 0.25)]) == (0.375, 0.375, 0.375)
    assert np.isnan(statistics.mean_of_means([x, y[:1]]).low)


@pytest.mark.parametrize(("count", "n"), [(0, 1), (1, 1), (0, 5), (3, 5), (5, 5), (572, 596), (1324, 1800)])
def test_the_interval_of_a_share_is_wilsons_formula(count, n):
    share, z = count / n, stats.norm.ppf(0.975)
    middle, half = share + z**2 / (2 * n), z * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    assert statistics.share_interval(count, n) == pytest.approx(
        (share, (middle - half) / (1 + z**2 / n), (middle + half) / (1 + z**2 / n)), abs=1e-12)


def test_a_share_without_a_trial_is_not_a_number():
    assert np.isnan(statistics.share_interval(0, 0)).all()


@pytest.mark.parametrize("n", [1, 4, 5, 9])
def test_the_sign_flip_test_tries_every_assignment(rng, n):
    difference = rng.normal(0.3, 1, n)
    sums = [abs(sum(sign * d for sign, d in zip(signs, difference)))
            for signs in itertools.product([1, -1], repeat=n)]
    by_hand = np.mean([total >= abs(difference.sum()) - 1e-9 for total in sums])
    assert statistics.sign_flip_test(difference, rng) == by_hand
    reference = stats.permutation_test((difference, np.zeros(n)), lambda x, y: np.mean(x - y),
                                       permutation_type="samples", n_resamples=np.inf) if n > 1 else None
    assert reference is None or by_hand == pytest.approx(reference.pvalue)


def test_the_smallest_p_of_five_pairs_is_one_in_sixteen(rng):
    assert statistics.sign_flip_test(np.array([0.1, 0.2, 0.3, 0.1, 0.5]), rng) == 2 / 2**5
    assert statistics.sign_flip_test(np.zeros(5), rng) == 1.0


def test_many_pairs_are_drawn_at_random_and_agree_with_the_normal_law(rng):
    difference = rng.normal(0.2, 1, 60)
    p = statistics.sign_flip_test(difference, rng)
    normal = 2 * stats.norm.sf(abs(difference.sum()) / np.sqrt((difference**2).sum()))
    assert p == pytest.approx(normal, rel=0.1)
    assert statistics.sign_flip_test(np.ones(60), rng) == 1 / 100_001


def test_t_intervals_of_three_seeds_hold_the_truth_as_often_as_they_say(rng):
    samples = rng.normal(0, 1, (3, 20_000))
    estimate = statistics.mean_interval(samples)
    assert np.mean((estimate.low < 0) & (estimate.high > 0)) == pytest.approx(0.95, abs=0.005)
