"""What moved objects do to surprise, on made-up walks whose answers can be counted by hand."""

from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.records import Prediction, Surprise
from curionav_cli.results import change_ages, change_pairs, changes, tables
from curionav_cli.results.changes import ELSEWHERE
from curionav_cli.results.runs import Run
from curionav_cli.results.statistics import Estimate
from curionav_cli.storage.run_folder import RunFolder

MOVES = {1: ((2, 0), (5, 0)), 4: ((5, 0), (2, 0))}  # episode -> from, to
NATS = {0: 5.0, 1: 3.0, 2: 1.0, ELSEWHERE: 1.0}  # by age; the model gets better from episode to episode


def events(index, moving):
    move = [{"what": "move", "item": "chair", "from": MOVES[index][0], "to": MOVES[index][1]}] if index in MOVES else []
    return ({"what": "light", "brightness": 1.0}, *(move if moving else []))


@pytest.fixture
def a_run(tmp_path, an_episode, a_plan):
    """Episodes of 12 frames: half stand beside the chair, which moves before episodes 1 and 4, half far away."""
    def make(moving, near=NATS, episodes=6, seed=3):
        run = RunFolder(tmp_path / f"changes_{moving}_{seed}")
        run.create(f"seed: {seed}\nenv: {{name: lab, changes: {str(moving).lower()}}}\nagent: {{name: lbs_dreamer}}\n"
                   "robot: {name: ideal}\n", {}, {}, a_plan())
        (run.path / "episodes").mkdir(exist_ok=True)
        for index in range(episodes):
            place = [5.5, 0, 0] if 1 <= index < 4 else [2.5, 0, 0]
            pose = np.array([place] * 6 + [[2.0, 9.0, 0.0]] * 6)
            age = [ELSEWHERE] * 6 if not index else [index - (1 if index < 4 else 4)] * 6
            kl = np.array([near[one] for one in age] + [NATS[ELSEWHERE]] * 6, np.float32)[None] / (index + 1)
            run.save_episode(index, replace(an_episode(steps=11), pose=pose, events=events(index, moving)))
            surprise = Surprise(np.arange(12)[None], kl, kl)
            empty = np.zeros((1, 1), np.float32)
            run.save_prediction(index, Prediction(np.array([1]), np.array([[1]]), np.zeros((1, 1, 64, 64, 3), np.uint8),
                                                  empty, empty, surprise))
        return Run.open(run.path)
    return make


def test_surprise_falls_with_the_age_of_a_move_and_the_control_has_none(a_run):
    still = dict.fromkeys(NATS, 1.0)
    found, lost = changes.pairs([a_run(True, episodes=7), a_run(False, near=still, episodes=7)])
    assert not lost
    for one, nats in zip(found, (NATS, still), strict=True):
        rows = {row["number"]: row for row in changes.age_rows(one)}
        assert list(rows) == [0, 1, 2, ELSEWHERE]
        assert {age: row["relative"].value for age, row in rows.items()} == pytest.approx(nats)
        assert [rows[age]["frames"] for age in rows] == [12, 12, 12, 12 + 6 * 6]
        summary = changes.summary(one)
        assert summary["near"] == pytest.approx(2 * 5 / 77) and summary["ever"] == pytest.approx(6 * 5 / 77)
    assert [changes.summary(one)["moves"] for one in found] == [2, 0]
    assert [changes.summary(one)["expected"] for one in found] == ["2", "0"]
    steps, share = changes.shares(found[:1], 2)
    assert steps.tolist() == [22, 44, 66, 77]
    assert share == pytest.approx([5 / 22, 0, 5 / 22, 0])


@pytest.mark.parametrize(("on", "off"), [(6, 3), (3, 6), (6, 6)])
def test_runs_of_different_length_are_paired_as_far_as_both_go(a_run, on, off):
    runs = [a_run(True, episodes=on), a_run(False, near=dict.fromkeys(NATS, 1.0), episodes=off)]
    found, _ = changes.pairs([replace(run, denominator="floor") for run in runs])
    [row] = change_pairs.rows(found)
    both = min(on, off)
    assert (row["n"], row["steps"], row["cost"]) == (1, 11 * both, "one pair: not decided")
    assert row["near_on"] == row["near_off"] == pytest.approx({3: 5, 6: 10}[both] / (11 * both))
    assert (row["fresh_on"], row["fresh_off"], row["fresh"].value) == pytest.approx((5, 1, 4))
    assert row["coverage_on"] == pytest.approx(2 / 24) and row["coverage"].value == 0
    assert f"| {11 * both} |" in tables.markdown([row], change_pairs.COLUMNS, "below")


@pytest.mark.parametrize(("points", "said"), [
    ((-2, -3, -1), "yes"), ((1, -2, 2.9), "no"), ((4, 1, 7), "no, it adds"), ((0, -4, 4), "not decided"),
    ((-9, np.nan, np.nan), "one pair: not decided")])
def test_change_costs_coverage_by_the_declared_rule(points, said):
    assert change_pairs.cost(Estimate(*points)) == said


def test_a_run_without_changes_is_left_out_alone_and_surprise_may_last(a_run):
    found, lost = changes.pairs([a_run(False)])
    assert not found and "no run of its world and seed 3" in lost[0]
    [one], _ = changes.pairs([a_run(True, near={**NATS, 2: 2.0}, episodes=7)])
    assert changes.summary(one)["expected"] == "not within 2"
    [one], _ = changes.pairs([a_run(True, near={**NATS, 2: 2.0}, seed=4)])
    assert changes.summary(one)["expected"] == "not within 1", "one episode of age 2 decides nothing"


def test_near_is_a_metre_from_the_old_place_too_and_the_youngest_counts():
    items = {"box": changes.Item((0, 0), (4, 0), 3), "chair": changes.Item((0.5, 0), (9, 0), 5)}
    pose = np.array([[0.0, 0.9, 0], [4.0, 0.9, 0], [4.0, 1.1, 0], [9.5, 0, 0]])
    assert changes.ages(pose, items, 5).tolist() == [2, 2, ELSEWHERE, 0]
    assert changes.ages(pose, items, 40).tolist() == [changes.OLDEST, changes.OLDEST, ELSEWHERE, changes.OLDEST]


def test_surprise_with_changes_less_without_is_paired_by_seed_and_age(a_run):
    nats = [(seed, {**NATS, 0: 5.0 + seed, 2: 1.0 + 0.1 * (seed - 2)}) for seed in (1, 2, 3)]
    found, _ = changes.pairs([run for seed, near in nats for run in (
        a_run(True, near, seed=seed), a_run(False, dict.fromkeys(NATS, 1.0), seed=seed))])
    rows = change_ages.rows(found)
    assert [(row["age"], row["n"], row.get("known")) for row in rows] == [
        ("0", 3, "yes"), ("1", 3, None), ("2", 3, None)]
    assert [row["on"] for row in rows] == pytest.approx([7, 3, 1]) and {row["off"] for row in rows} == {1.0}
    assert tuple(rows[0]["less"]) == pytest.approx((6, 6 - 2.484, 6 + 2.484), abs=1e-3), "t of two degrees of freedom"
    assert [row["known"] for row in change_ages.rows(found[:4])[:1]] == ["fewer than 3 pairs: not decided"]


@pytest.mark.parametrize(("lows", "said"), [
    ((0.1, 0.1, 0.1, -0.1, 0.0), "yes"), ((0.1, 0.1, -0.1, -0.1, 0.1), "no"), ((0.1, -0.1), "yes"),
    ((0.1, 0.1), "no older moves: not decided"), ((-0.1, 0.1), "not tested: no surprise at what just moved")])
def test_what_moved_is_known_from_the_age_on_at_which_surprise_is_gone(lows, said):
    assert change_ages.known({age: Estimate(low + 0.2, low, low + 0.4) for age, low in enumerate(lows)}) == said


@pytest.mark.parametrize("columns", [change_pairs.COLUMNS, change_ages.COLUMNS, changes.COLUMNS, changes.AGE_COLUMNS])
def test_no_heading_stands_for_two_columns(columns):
    """On a terminal a cell is found by its heading."""
    assert len({heading for heading, _, _ in columns}) == len(columns)
