"""The parts of benchmarks/learner.py, with our learner alone, at toy size."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from tiny import LEARNER

HOME = Path(__file__).resolve().parents[2]
TOY = tuple(word for word in LEARNER if word.startswith("agent."))


@pytest.fixture
def learner(monkeypatch):
    monkeypatch.syspath_prepend(str(HOME / "benchmarks"))
    import learner

    monkeypatch.setitem(learner.STEPS, learner.CPU, 20)
    return learner


def test_the_papers_update_by_formula(learner):
    """Counted by hand beforehand: 1.94 TFLOP at scale=paper."""
    assert learner.dense(learner.hyper("paper", ())[1]) == pytest.approx(1940, rel=0.005)


@pytest.mark.slow
def test_ours_is_measured_and_an_absent_peer_is_named(learner, monkeypatch, tmp_path):
    ours = learner.Row("curionav", "float32", TOY)
    monkeypatch.setitem(learner.ROWS, "cpu", [ours, learner.Row("sheeprl", "float32", TOY)])
    text = learner.section("cpu", "cpu", repeats=2, only="", peers=tmp_path)
    assert "Left out: sheeprl, float32. It is not installed" in text
    line = next(line for line in text.splitlines() if line.startswith(f"| {ours} "))
    seconds, low, high, gflop, rate = (float(number) for number in re.findall(r"\d\S*", line.split("|", 2)[2])[:5])
    assert 0 < low <= seconds <= high
    assert rate == pytest.approx(gflop / seconds, rel=0.3)


def test_what_is_counted_is_what_the_formula_says(learner):
    """Every frame decoded and every state imagined from: within a twentieth, however the products are arranged."""
    from learner_contenders import Curionav

    words, shapes = learner.hyper("cpu", (*learner.PEERS_WORK, "agent.batch_size=4", "agent.imagination_starts=80"))
    ours = Curionav({"device": "cpu", "precision": "float32", "times": 1, "hyper": shapes, "overrides": words})
    assert ours.warm() == pytest.approx(learner.dense(shapes, again=False), rel=0.05)


@pytest.mark.slow
def test_a_contender_that_dies_is_named(learner, monkeypatch, tmp_path):
    monkeypatch.setitem(learner.ROWS, "cpu", [learner.Row("curionav", "float64", TOY, "the same work")])
    with pytest.raises(SystemExit, match=r"Left out: curionav, the same work, float64. It ended: .*float64"):
        learner.section("cpu", "cpu", repeats=1, only="", peers=tmp_path)


def test_a_section_is_written_between_its_marks(learner, monkeypatch, tmp_path):
    import simulator

    results = tmp_path / "RESULTS.md"
    results.write_text("a\n<!-- one -->\nold\n<!-- /one -->\nb\n<!-- two -->\n<!-- /two -->\n")
    monkeypatch.setattr(simulator, "RESULTS", results)
    simulator.write("new", "one")
    assert results.read_text() == "a\n<!-- one -->\nnew\n<!-- /one -->\nb\n<!-- two -->\n<!-- /two -->\n"


def test_the_marks_of_every_table_stand_in_the_results(learner):
    text = (HOME / "benchmarks" / "RESULTS.md").read_text()
    for scale in learner.ROWS:
        for device in (learner.CPU, learner.CUDA):
            assert f"<!-- learner {scale} {device} -->" in text
            assert f"<!-- /learner {scale} {device} -->" in text


def test_the_command_says_what_it_takes():
    done = subprocess.run([sys.executable, HOME / "benchmarks" / "learner.py", "--help"], capture_output=True,
                          text=True, env={**os.environ, "COLUMNS": "120"}, check=True)
    assert "--device" in done.stdout and "pip install" in done.stdout
