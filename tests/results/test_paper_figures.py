"""The paper's figures: which runs stand in them, at whose axes, and what is said of those that end early."""

import pytest
from lengths import a_summary

from curionav_cli.results import paper_figures, paper_lengths, plots
from curionav_cli.results.comparison.comparison import compare


def test_runs_of_different_length_all_stand_in_it_each_once():
    runs = [a_summary(steps=1000), a_summary(steps=2000), a_summary(seed=1, steps=300), a_summary(agent="cbet")]
    shown = paper_lengths.drawn(compare(runs))
    assert [(one.arm, one.run.seed, one.run.steps) for one in shown] == [
        ("lbs_dreamer", 0, 2000), ("lbs_dreamer", 1, 300), ("cbet", 0, 2_000_000)]
    assert [one.planned for one in shown] == [2_000_000, 2_000_000, 5_000_000]
    assert paper_figures.cut_short(shown) == "lbs_dreamer until 300; cbet until 2M"
    assert paper_figures.cut_short([*shown[:1], shown[2]._replace(run=shown[0].run)]) == "all arms until 2k"


def test_ours_is_the_papers_agent_in_the_papers_world():
    runs = [a_summary("large_lab", **{"agent.curiosity": "lbs"}),
            a_summary("large_lab", **{"agent.curiosity": "shuffled"}),
            a_summary("large_lab", changes=False, **{"agent.curiosity": "lbs"}), a_summary("large_lab", "cbet")]
    assert [one.ours for one in paper_lengths.drawn(compare(runs))] == [True, False, False, False]


def test_curves_end_where_their_runs_end_and_the_axis_where_the_papers_does():
    runs = [a_summary(env, agent, seed, steps) for env in ("apartment_0", "apartment_1")
            for agent, seed, steps in (("lbs_dreamer", 0, 2_000_000), ("cbet", 0, 5_000_000), ("cbet", 1, 1_000_000))]
    comparison = compare(runs)
    figure = paper_figures.curves(paper_lengths.drawn(comparison), plots.looks(comparison.arms))
    left, _, mean = figure.axes[:3]
    assert left.get_xlim() == mean.get_xlim() == (0, 5_000_000)
    ends = {line.get_label(): line.get_xdata()[-1] for line in left.lines if not line.get_label().startswith("_")}
    assert ends == {"lbs_dreamer": 2_000_000, "cbet": 1_000_000}  # of the mean: as far as all its runs go
    assert left.get_xlabel() == "steps\ncbet until 1M"
    assert [line.get_ydata()[-1] for line in mean.lines[:2]] == [20.0, 20.0]


@pytest.mark.parametrize(("env", "best"), [("apartment_0", ["lbs_dreamer_1", "cbet_0"])])
def test_the_best_run_of_each_arm_is_the_one_that_covered_most(env, best):
    runs = [a_summary(env), a_summary(env, seed=1, found=(0, 1, 2)), a_summary(env, "cbet"),
            a_summary("apartment_1", "cbet", found=(1, 2, 3))]
    found = paper_figures.best(paper_lengths.drawn(compare(runs)), env)
    assert [f"{one.run.agent}_{one.run.seed}" for one in found] == best
