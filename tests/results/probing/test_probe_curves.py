"""Measurements on probes sorted into environments, axes and arms; on curves made by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from curionav_cli.results.plots import looks
from curionav_cli.results.probing import estimates
from curionav_cli.results.probing import plots as probe_plots
from curionav_cli.results.probing.curves import STEPS, UPDATES, ProbeCurve, collected, sort_into_fields


def a_curve(explorer: str = "random", seed: int = 0, error: tuple[float, ...] = (0.03, 0.02), every: int = 100,
            axis: str = UPDATES, probe: str = "a", **settings) -> ProbeCurve:
    values = {"error": np.array(error), "surprise": 100 * np.array(error), "repeat": np.full(len(error), 0.04)}
    at = every * np.arange(1, len(error) + 1)
    return ProbeCurve(Path(f"{explorer}_{seed}_{len(error)}_{every}"), {"name": "room"}, f"lbs_dreamer on {explorer}",
                      explorer, (seed, seed), "cpu", settings, {}, axis, at, values, frozenset({probe}))


def test_arms_meet_at_the_last_measurement_that_all_have() -> None:
    curves = [a_curve(seed=seed, error=(0.03, 0.02, 0.01)) for seed in (0, 1)] + [
        a_curve("bounce", seed, (0.02, 0.01 * seed)) for seed in (0, 1)]
    [field], left_out = sort_into_fields(curves, {})
    assert (field.env, field.axis, field.at, left_out) == ("room", UPDATES, 200, [])
    assert list(field.arms) == ["lbs_dreamer on random", "lbs_dreamer on bounce"]
    ours, theirs = reversed(field.arms)
    np.testing.assert_allclose(field.difference(ours, theirs, "error"), [-0.02, -0.01])
    [first, second] = estimates.arm_rows([field])
    assert first["probe_error"].value == pytest.approx(0.02) and second["probe_surprise"].value == pytest.approx(0.5)
    [pair] = estimates.pair_rows([field], "lbs_dreamer on random", np.random.default_rng(0))
    assert pair["probe_error"].value == pytest.approx(-0.015) and pair["p"] == 0.5 and pair["n"] == 2
    notes = list(estimates.notes([field]))
    assert any("after 200 updates" in note and "300" in note for note in notes)
    assert any("fewer than 5 seeds measured" in note for note in notes)
    assert len(list(estimates.point_rows([field]))) == 10


def test_what_is_left_out_is_named() -> None:
    curves = [a_curve(), a_curve(error=(0.03, 0.02, 0.01)), a_curve("bounce"), a_curve("mapper", every=1000)]
    [field], left_out = sort_into_fields(curves, {})
    assert field.at == 200 and list(field.arms) == ["lbs_dreamer on random", "lbs_dreamer on bounce"]
    assert [line.rpartition(" ")[2] for line in left_out] == ["random_0_2_100", "mapper_0_2_1000"]


def test_another_axis_is_another_field_and_runs_keep_the_name_they_have() -> None:
    run = replace(a_curve("lbs_dreamer", axis=STEPS), folder=Path("run"))
    fields, _ = sort_into_fields([a_curve(), run], {Path("run"): ("the room", "ours")})
    assert [(field.env, field.axis, list(field.arms)) for field in fields] == [
        ("room", UPDATES, ["lbs_dreamer on random"]), ("the room", STEPS, ["ours"])]


def test_arms_of_other_settings_are_kept_apart_and_other_probes_are_warned_of() -> None:
    curves = [a_curve(**{"agent.action_repeat": 1}), a_curve(seed=1, probe="b", **{"agent.action_repeat": 4})]
    [field], _ = sort_into_fields(curves, {})
    assert list(field.arms) == ["lbs_dreamer on random action_repeat=1", "lbs_dreamer on random action_repeat=4"]
    assert any("2 different probes" in note for note in estimates.notes([field]))


def test_a_training_is_named_by_who_collected_its_episodes() -> None:
    runs = [{"agent": {"name": name, "goal": "x"}, "seed": seed} for name, seed in
            (("random", 0), ("mapper", 0), ("random", 1))]
    assert collected(runs, {}) == ("random+mapper", {"data.name": "random", "data.goal": "x", "data1.name": "mapper",
                                                     "data1.goal": "x"})
    assert collected([], {"episodes": {"a": "1"}})[0] == "episodes"


def test_the_figure_shows_every_arm_and_ends_where_all_do() -> None:
    curves = [a_curve(name, seed, (0.03, 0.02)) for name in ("random", "bounce") for seed in (0, 1)]
    [field], _ = sort_into_fields([*curves, a_curve("mapper", error=(0.03, 0.02, 0.01))], {})
    figure = probe_plots.figure(field, looks(field.looks()))
    error, surprise = figure.axes
    ends = {line.get_label(): line.get_xdata()[-1] for line in surprise.get_lines() if line.get_label()[0] != "_"}
    assert ends == {f"lbs_dreamer on {name}": 200 for name in ("random", "bounce", "mapper")}
    assert "the last seen frame, repeated" in [line.get_label() for line in error.get_lines()]
