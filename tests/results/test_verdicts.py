"""Verdicts on the paper's claims: what is missing of runs may not decide, and what cannot change is decided."""

import numpy as np
import pytest
from lengths import a_summary

from curionav_cli.records import FloorPlan, Pose
from curionav_cli.results import unfinished, verdicts
from curionav_cli.results.comparison.comparison import compare
from curionav_cli.results.paper_lengths import drawn
from curionav_cli.results.unfinished import Bounds
from curionav_cli.storage.run_folder import RunFolder

LAB, ROOM, MORE, LEVEL = "60 % of the lab", "over 80 %", "more than C-BET in apartment 0", "level with"
BOUNCE, CONTROL = "beyond the paper: passes bounce", "beyond the paper: passes its"


def a_run(env, share, steps, seed=0, agent="lbs_dreamer", **arm):
    """A run of 10 M cells that has this share of them from its first step on."""
    found = np.zeros(round(share * 100), np.int64)
    return a_summary(env, agent, seed, steps, found, cells=100, **arm)


def judged(monkeypatch, *runs, claim):
    monkeypatch.setattr(unfinished, "visits", lambda run: (100, 10, 1, 10))
    [found] = [row for row in verdicts.rows(drawn(compare(runs))) if row["claim"].startswith(claim)]
    return found


@pytest.mark.parametrize(("claim", "runs", "said"), [
    (LAB, [], "not decided"),
    (LAB, [("large_lab", 0.6, 600_000)], "not decided; of these runs alone: seen"),
    (LAB, [("large_lab", 0.6, 600_000), ("large_lab", 0.52, 600_000, 1)], "seen"),
    (LAB, [("large_lab", 0.6, 600_000), ("large_lab", 0.4, 600_000, 1)], "not seen"),
    (LAB, [("large_lab", 0.6, 300_000), ("large_lab", 0.55, 1000, 1)], "seen"),  # coverage never falls
    (LAB, [("large_lab", 0.3, 599_999), ("large_lab", 0.3, 600_000, 1)], "not seen"),  # a step adds one cell
    (LAB, [("large_lab", 0.3, 599_000), ("large_lab", 0.3, 600_000, 1)], "not decided"),
    (ROOM, [("small_room", 0.8, 280_000), ("small_room", 0.81, 5000, 1)], "seen"),
    (ROOM, [("small_room", 0.8, 280_000), ("small_room", 0.8, 140_000, 1)], "not seen"),
    (ROOM, [("small_room", 0.8, 280_000), ("small_room", 0.8, 139_000, 1)], "not decided"),
    (MORE, [("apartment_0", 0.5, 2_000_000)], "not decided"),
    (MORE, [("apartment_0", 0.5, 2_000_000), ("apartment_0", 0.45, 5_000_000, 0, "cbet")],
     "not decided; of these runs alone: seen"),
    (MORE, [("apartment_0", 0.5, 2_000_000), ("apartment_0", 0.46, 9000, 0, "cbet")], "not seen"),  # a best only rises
    (LEVEL, [("apartment_2", 0.5, 2_000_000), ("apartment_2", 0.56, 5_000_000, 0, "cbet")], "not seen"),
    (LEVEL, [("apartment_2", 0.5, 2_000_000), ("apartment_2", 0.55, 5_000_000, 0, "cbet")],
     "not decided; of these runs alone: seen"),
    (BOUNCE, [("large_lab", 0.5, 600_000, seed) for seed in (0, 1)] +
     [("large_lab", 0.5, 600_000, seed, "bounce") for seed in (0, 1, 2)], "not seen"),
    (CONTROL, [("large_lab", 0.5, 600_000), ("large_lab", 0.51, 600_000, 1)], "not decided"),
])
def test_a_claim_is_decided_where_nothing_missing_could_change_it(monkeypatch, claim, runs, said):
    runs = [a_run("large_lab", 0.1, 600_000, 0, "random"), *(a_run(*run) for run in runs)]  # never of the paper's agent
    assert judged(monkeypatch, *runs, claim=claim)["verdict"] == said


def test_runs_of_unequal_length_have_no_mean(monkeypatch):
    long, short = a_run("large_lab", 0.6, 600_000), a_run("large_lab", 0.4, 9000, 1)
    assert judged(monkeypatch, long, short, claim=LAB)["ours"] == "60.0%, 40.0%"
    assert judged(monkeypatch, long, a_run("large_lab", 0.4, 600_000, 1), claim=LAB)["ours"] == "50.0% (60.0%, 40.0%)"


def test_all_three_arms_of_cbet_count_and_only_with_their_own_reward(monkeypatch):
    ours = a_run("apartment_0", 0.5, 2_000_000)
    theirs = [a_run("apartment_0", share, 5_000_000, 0, agent, **{"agent.view": view, "agent.reward": "cbet"})
              for share, agent, view in ((0.4, "cbet", "pano"), (0.3, "cbet", "ego"), (0.2, "cbet_lifelong", "pano"))]
    oracle = a_run("apartment_0", 1.0, 5_000_000, 0, "cbet", **{"agent.view": "pano", "agent.reward": "count_oracle"})
    found = judged(monkeypatch, ours, *theirs, oracle, claim=MORE)
    assert found["verdict"] == "seen" and (found["low"], found["high"]) == pytest.approx((0.1, 0.1))
    assert "beside 40.0% (cbet view=pano reward=cbet, 5,000,000 steps)" in found["ours"], "and 3 of 3 arms"
    assert judged(monkeypatch, ours, *theirs, claim=MORE)["ours"].endswith("; 3 of 3 arms")


def test_ours_and_its_control_are_compared_at_equal_steps(monkeypatch):
    runs = [a_run("large_lab", 0.5, 40_000, **{"agent.curiosity": "lbs"}),
            a_run("large_lab", 0.1, 600_000, 0, "bounce"),
            a_run("large_lab", 0.2, 20_000, **{"agent.curiosity": "shuffled"})]
    rows = verdicts.against(drawn(compare(runs)))
    assert [(row["minus"], row["steps"]) for row in rows] == [
        ("bounce", 10_000), ("bounce", 30_000), ("bounce", 40_000),
        ("lbs_dreamer curiosity=shuffled", 10_000), ("lbs_dreamer curiosity=shuffled", 20_000)]
    assert [round(row["difference"]) for row in rows] == [40, 40, 40, 30, 30]
    assert rows[0]["area"] == pytest.approx(0.4) and rows[0]["n"] == "1 and 1"
    assert "50.0% beside 20.0% at 20,000 steps; 1 of 1 of" in judged(monkeypatch, *runs, claim=CONTROL)["ours"]


def test_visits_are_counted_by_the_distance_from_the_dock(tmp_path, an_episode):
    """A corridor of 20 m, one cell wide: 50 visits near the dock and 4 beyond 15 m, of 50 cells each."""
    line = np.ones((1, 200), bool)
    run = RunFolder(tmp_path / "lab")
    run.create("seed: 0\nenv: {name: large_lab}\nagent: {name: lbs_dreamer}\nrobot: {name: ideal}\n", {}, {},
               FloorPlan(line, line, ~line, 0.1, Pose(0.0, 0.05, 0.0), 0.18))
    x = np.array([1.0] * 50 + [7.0] * 3 + [15.1] * 4)
    episode = an_episode(steps=len(x) - 1)
    episode.pose[:] = np.column_stack([x, np.full(len(x), 0.05), np.zeros(len(x))])
    run.save_episode(0, episode)
    runs = {0: a_summary("large_lab", steps=600, folder=run.path), 1: None}
    now, bounds = unfinished.near_dock({0: runs[0]}, 600)
    assert now == pytest.approx(12.5) and bounds == pytest.approx((12.5, 12.5))
    now, bounds = unfinished.near_dock(runs, 600)  # the other run may be anywhere
    assert now == pytest.approx(12.5) and bounds == pytest.approx((50 / 604, (50 + 1200) / 4))


@pytest.mark.parametrize(("bounds", "form", "written"), [
    (Bounds(0.5, 0.5), ".1%", "50.0%"), (Bounds(0.25, 1.0), ".1%", "25.0% to 100.0%"),
    (Bounds(-0.1, 0.2), "+.1%", "-10.0% to +20.0%"), (Bounds(0.5, np.inf), ".1f", "0.5 or more")])
def test_bounds_are_written_as_one_reads_them(bounds, form, written):
    assert bounds.written(form) == written
