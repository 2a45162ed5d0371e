"""The course of learning: stretches and tenths of thousands of episodes, counted by hand."""

import json

import numpy as np
import pytest

from curionav_cli.results import learning
from curionav_cli.results.runs import Run
from curionav_cli.storage.run_folder import RunFolder


@pytest.fixture
def a_run(tmp_path, a_plan):
    """a_run(4000): metrics of so many episodes; the KL of episode n is n."""
    def make(episodes):
        run = RunFolder(tmp_path / "run")
        run.create("seed: 0\nenv: {name: small_room}\nagent: {name: lbs_dreamer}\nrobot: {name: ideal}\n", {}, {},
                   a_plan())
        run.write("metrics.jsonl", "".join(json.dumps(
            {"episode": n, "steps": 500 * (n + 1), "kl": n, "updates": n, "cells_in_episode": 3,
             **({"open_loop_mse_5": 0.5} if n % 2 else {})}) + "\n" for n in range(episodes)))
        return Run.open(run.path)
    return make


def test_a_stretch_is_its_mean_and_its_middle_at_its_last_step():
    found = learning.stretches([(500 * n, float(n)) for n in range(4000)])
    assert found.shape == (4, learning.BINS)
    assert found[:, 0] == pytest.approx([500 * 39, 3.9, 19.5, 35.1])
    assert learning.stretches([(500, 2.0), (1000, 4.0)]).tolist() == [[500, 1000], [2, 4], [2, 4], [2, 4]]


def test_a_tenth_has_the_means_of_its_episodes(a_run):
    run = a_run(4000)
    rows = list(learning.stages(run, run.folder.metrics()))
    assert [(row["first_episode"], row["last_episode"]) for row in rows[:2]] == [(0, 399), (400, 799)]
    assert [row["kl"] for row in rows] == pytest.approx(np.arange(10) * 400 + 199.5)
    assert rows[9]["steps"] == 2_000_000 and rows[0]["open_loop_mse_5"] == 0.5
    assert rows[0]["actor_entropy"] is None and rows[0]["novelty_ratio"] is None


def test_a_short_run_has_no_course(a_run, tmp_path):
    assert learning.draw(a_run(learning.LEAST - 1), tmp_path) == []
    assert not list(tmp_path.glob("*.png"))
