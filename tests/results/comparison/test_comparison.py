"""Runs sorted into arms and environments, their measures and estimates, on curves made by hand."""

import csv
import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from curionav_cli.results import paper, tables
from curionav_cli.results.comparison import estimates
from curionav_cli.results.comparison import plots as comparison_plots
from curionav_cli.results.comparison.comparison import compare, measures
from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.comparison.tables import arm_table, latex, pair_table
from curionav_cli.results.coverage import Curve
from curionav_cli.results.plots import looks, save


def a_summary(agent="random", seed=0, found=(0, 2, 4), steps=20, env="room", state="done", gaps=(), **settings):
    """Two episodes in a room of ten cells."""
    half = steps // 2
    spent = {"seconds": [0, 1, 3], "cpu_seconds": [0, 1, 2], "updates": [0, 5, 10], "frames_read": [0, np.nan, np.nan]}
    budget, curve = {key: np.array(sums, float) for key, sums in spent.items()}, Curve(np.array(found), steps, 10)
    return RunSummary(Path(f"{env}_{agent}_{seed}_{steps}"), {"name": env}, agent, seed, "cpu", settings, {}, curve,
                      np.array([0, half, steps]), budget, state, "", state == "done" and not gaps, gaps)


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def some(agent, starts, env="room"):
    return [a_summary(agent, seed, np.arange(start, start + 8), env=env) for seed, start in enumerate(starts)]


def test_the_measures_of_a_run_by_hand():
    run = a_summary(found=(0, 2, 4, 9, 15), steps=20)
    numbers = measures(run, 10, [4, 30])
    assert numbers["coverage"] == 0.4 and numbers["coverage_at_4"] == 0.3 and "coverage_at_30" not in numbers
    by_hand = np.mean([np.sum(run.curve.found <= step) / 10 for step in range(10)])
    assert numbers["area_under_curve"] == pytest.approx(by_hand)
    assert measures(run, 20, [])["steps_to_50"] == 15 and numbers["steps_to_50"] is None
    assert (numbers["seconds"], measures(run, 11, [])["seconds"]) == (1, 3)  # the learning after the episode counts
    assert numbers["updates"] == 5 and numbers["frames_read"] is None


def test_runs_of_different_length_meet_at_the_shortest_and_the_unfinished_stand_aside():
    runs = [a_summary(seed=0), a_summary(seed=1, steps=40), a_summary(seed=2, steps=10, state="failed"),
             a_summary(seed=3, steps=30, state="running"), a_summary(seed=4, steps=12, gaps=("episode 1 is missing",)),
             a_summary(seed=1, steps=8)]
    result = compare(runs)
    [field] = result.fields
    assert field.horizon == 20 and [run.seed for run in field.arms["random"]] == [0, 1, 3]
    assert {(run.seed, run.steps): why for run, why in result.left_out.items()} == {
        (2, 10): "10 steps, and 20 are compared", (4, 12): "12 steps, and 20 are compared",
        (1, 8): "the same arm, environment and seed as room_random_1_40"}
    said = list(estimates.notes(result, None))
    assert sum(line.startswith("LEFT OUT: room, random, seed") for line in said) == 3
    assert "GAP: episode 1 is missing" in said and any("Not finished (running)" in line for line in said)
    assert any("compared up to 20 steps" in line and "40" in line for line in said)
    assert any("fewer than 5 seeds" in line and "random in room (3)" in line for line in said)
    assert len(list(estimates.run_rows(result, []))) == 6


def test_the_papers_claim_is_told_against_each_cbet_and_which_is_the_best():
    runs = [run for agent, starts in {"lbs_dreamer": [4, 5, 6], "cbet": [5, 6, 7], "cbet_lifelong": [1, 1, 2]}.items()
             for run in some(agent, starts, env="apartment_0")]
    numbers = {number.what: number.ours for number in paper.coverage(compare(runs))}
    area = ", apartment_0: area under the curve"
    assert numbers[f"lbs_dreamer minus cbet{area}"].startswith("+0.04")
    assert numbers[f"lbs_dreamer minus cbet_lifelong, the best C-BET of 2{area}"].startswith("-0.14")
    assert {env for env in paper.SIZES if numbers.get(f"coverage, {env}") == "no run was given"} == {
        "apartment_1", "apartment_2", "small_room", "large_lab"}


def test_where_no_run_is_finished_the_shortest_counts():
    [field] = compare([a_summary(seed=0, steps=10, state="running"), a_summary(seed=1, state="failed")]).fields
    assert field.horizon == 10 and len(field.arms["random"]) == 2


def test_only_shared_seeds_are_paired(rng):
    ours, theirs = some("sticky", [1, 2, 3, 4]), some("random", [5, 6, 8])[::-1]
    result = compare([*ours, *theirs[:2], a_summary("random", 9)])
    [row] = [row for row in estimates.pair_rows(result, None, rng) if row["env"] == "room"]
    areas = [[run.curve.area() for run in runs] for runs in (ours[1:3], [theirs[1], theirs[0]])]
    reference = stats.ttest_rel(*areas)
    assert (row["arm"], row["minus"], row["n"]) == ("sticky", "random", 2)
    assert row["difference"].value == pytest.approx(np.mean(areas[0]) - np.mean(areas[1]))
    assert row["difference"].low == pytest.approx(reference.confidence_interval().low) and row["p"] == 0.5


def test_all_others_beside_a_baseline_and_over_all_environments(rng):
    runs = [run for env in ("room", "lab") for agent, first in (("bounce", 1), ("random", 6), ("sticky", 3))
             for run in some(agent, first + np.arange(5) % 3, env)]
    rows = list(estimates.pair_rows(compare(runs), "random", rng))
    assert [(row["env"], row["arm"]) for row in rows] == [
        (env, arm) for env in ("room", "lab", "all") for arm in ("bounce", "sticky")]
    assert {row["minus"] for row in rows} == {"random"}
    assert rows[-1]["n"] == 10 and rows[-1]["p"] == 2 / 2**10 and rows[-1]["improvement"].value == 1
    assert rows[-1]["difference"].value == pytest.approx(rows[1]["difference"].value)
    [bounce, *_] = estimates.overall_rows(compare(runs), rng)
    areas = [run.curve.area() for run in runs if run.agent == "bounce"]
    assert bounce["n"] == 10 and bounce["interquartile_mean"].value == pytest.approx(stats.trim_mean(areas, 0.25))


def test_an_environment_that_an_arm_did_not_see_says_nothing_over_all(rng):
    result = compare([*some("bounce", [1, 2]), *some("random", [3, 4]), *some("random", [3, 4], "lab")])
    assert [field.env for field in result.common] == ["room"]
    assert any("Not every arm has runs in lab: left out" in line for line in estimates.notes(result, None))
    apart = compare([*some("bounce", [1, 2]), *some("random", [3, 4], "lab")])
    assert not apart.common and not list(estimates.overall_rows(apart, rng))
    assert any("nothing is said over all" in line for line in estimates.notes(apart, None))


def test_arms_that_did_the_same_or_share_no_seed_are_named():
    runs = [*some("bounce", [1, 2]), *some("sticky", [1, 2]), a_summary("random", seed=7)]
    said = list(estimates.notes(compare(runs), "sticky"))
    assert "room: bounce and sticky covered the same in every shared seed." in said
    assert "room: random and sticky share no seed, so there is no paired difference." in said


def test_arms_and_worlds_that_differ_in_a_setting_are_kept_apart():
    runs = [a_summary(seed=seed, **{"agent.gamma": gamma}) for seed in (0, 1) for gamma in (0.9, 0.99)]
    result = compare(runs)
    assert list(result.arms) == ["random gamma=0.9", "random gamma=0.99"]
    assert [run.seed for run in result.fields[0].arms["random gamma=0.9"]] == [0, 1]
    worlds = [a_summary(seed=0), a_summary(seed=1)]
    worlds[1].world["env.changes"] = False
    assert [field.env for field in compare(worlds).fields] == ["room changes=?", "room changes=false"]


def test_two_maps_of_one_name_are_two_environments_named_by_their_paths():
    places = [("north", 1), ("south", 2), ("moved/away", 1)]
    runs = [replace(a_summary(seed=seed), env={"map": f"/data/{place}/office.yaml"}, world={"cells": cells})
             for seed, (place, cells) in enumerate(places)]
    assert [(field.env, len(field.arms["random"])) for field in compare(runs).fields] == [
        ("north/office", 2), ("south/office", 1)]


def test_a_share_that_few_reach_has_no_median_and_says_how_many_did():
    runs = [a_summary(seed=seed, found=np.arange(found)) for seed, found in enumerate((9, 9, 4, 4, 9))]
    [row] = estimates.arm_rows(compare(runs), [])
    assert f"{row['steps_to_50']:,.0f}" == "4 (3/5)" and f"{row['steps_to_90']:,.0f}" == "8 (3/5)"
    runs[0].curve.found[:] += 100
    [row] = estimates.arm_rows(compare(runs), [])
    assert f"{row['steps_to_50']:,.0f}" == "- (2/5)"


def test_steps_until_an_agent_said_that_nothing_was_left():
    runs = [replace(a_summary(seed=seed), explored=explored) for seed, explored in enumerate((5, 7, None, 9999))]
    result = compare(runs)
    assert [measures(run, result.fields[0].horizon, [])["steps_to_explored"] for run in runs] == [5, 7, None, None]
    [row] = estimates.arm_rows(result, [])
    assert f"{row['steps_to_explored']:,.0f}" == "- (2/4)" and f"{row['steps_to_99']:,.0f}".endswith("/4)")


def test_tables_keep_bounds_and_counts_and_latex_escapes(rng):
    result = compare([*some("lbs_dreamer", range(5)), *some("random", range(3, 8))])
    parts = [arm_table(list(estimates.arm_rows(result, [10])), [10], "visitable cells"),
             pair_table(list(estimates.pair_rows(result, None, rng)))]
    [first, _] = csv.DictReader(io.StringIO(tables.comma_separated(parts[0].rows)))
    low, area, high = (float(first[f"area_under_curve{bound}"]) for bound in ("_low", "", "_high"))
    assert low < area < high
    assert first["steps_to_50_runs"] == "5" and first["frames_read"] == "" and float(first["updates"]) == 10
    text = latex("curionav compare sweep_1", ["five % of them"], parts)
    assert r"lbs\_dreamer" in text and "^" not in text and text.count(r"\begin{tabular}") == 2
    assert tables.escaped(r"a_\b^2") == r"a\_-b-2"
    for line in text.splitlines():
        if line.endswith(r"\\"):
            assert line.count("&") in (len(parts[0].columns) - 1, len(parts[1].columns) - 1)


def test_every_seed_is_drawn_and_the_same_bytes_again(tmp_path, rng):
    result = compare([*some("lbs_dreamer", range(5)), *some("random", range(3, 8)), *some("unheard_of", [2])])
    look = looks(result.arms)
    pairs = list(estimates.pair_rows(result, None, rng))
    figure = comparison_plots.environment(result.fields[0], look, pairs, "lbs_dreamer", "cells")
    left, middle, right = figure.axes
    assert len(left.lines) == 5 + 5 + 1 + 3
    drawn = [line.get_xdata().tolist() for line in middle.lines if line.get_marker() == "."]
    assert [len(dots) for dots in drawn] == [5, 5, 1]
    assert drawn[0] == result.fields[0].scores("lbs_dreamer").tolist()
    assert [text.get_text() for text in right.texts] == ["", "n = 5\np = 0.062", "n = 1\np = 1"]
    alone = comparison_plots.environment(result.fields[0], look, pairs, "absent", "cells")
    assert [axes.get_visible() for axes in alone.axes] == [True, True, False]
    thresholds = np.linspace(0, 1, 11)
    profiles = estimates.profiles(result, thresholds, rng)
    rows = list(estimates.overall_rows(result, rng))
    for turn in ("one", "two"):
        save(comparison_plots.environment(result.fields[0], look, pairs, "lbs_dreamer", "cells"), tmp_path / turn)
        save(comparison_plots.over_all(result, look, pairs, "lbs_dreamer", rows, profiles, thresholds),
             tmp_path / f"all_{turn}")
    for kind in ("png", "pdf"):
        assert (tmp_path / f"one.{kind}").read_bytes() == (tmp_path / f"two.{kind}").read_bytes()
        assert (tmp_path / f"all_one.{kind}").read_bytes() == (tmp_path / f"all_two.{kind}").read_bytes()


def test_no_two_arms_look_alike_and_an_agent_keeps_its_look():
    arms = {f"lbs_dreamer seed={n}": "lbs_dreamer" for n in range(7)} | {"random": "random", "new": "new"}
    look = looks(arms)
    assert len({str(one.dashes) for one in look.values()}) == len({one.color for one in look.values()}) == 9
    assert looks({"random": "random"})["random"] == look["random"]


def test_a_variant_has_the_same_look_in_every_figure():
    two = looks({"cbet view=pano": "cbet", "cbet view=ego": "cbet"})
    many = looks({f"cbet reward={name}": "cbet" for name in ("count", "rnd", "cbet view=ego", "cbet view=pano")})
    assert two["cbet view=pano"] == many["cbet reward=cbet view=pano"] == looks({"cbet": "cbet"})["cbet"]
    assert two["cbet view=ego"] == many["cbet reward=cbet view=ego"] and len(set(many.values())) == 4


def test_as_many_environments_as_there_are_have_a_panel_and_one_is_over_all():
    result = compare([run for place in range(9) for run in some("random", range(2), env=f"room_{place}")])
    figure = comparison_plots.courses(result, looks(result.arms), "cells")
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert [title for title in titles if title] == [
        *(f"{letter}  room_{place}" for place, letter in enumerate("abcdefghi")), "j  over all runs"]
