"""C-BET by the command line: a run that goes on, and wrong settings answered in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from entry import Cli
from leftovers import repeatable

pytestmark = pytest.mark.usefixtures("blank_figures")
TINY = ("env=small_room", "device=cpu", "loop.steps=20", "agent.unroll=10", "agent.batch_size=3",
        "agent.conv_channels=[4,4]", "agent.dense_units=[8]", "agent.lstm_units=8")


def rows(run: Path) -> list[dict]:
    lines = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    return repeatable(lines)


@pytest.mark.parametrize("agent", ["cbet", "cbet_lifelong"])
def test_a_run_goes_on_as_if_it_had_never_stopped(cli: Cli, tmp_path: Path, agent: str) -> None:
    words = (*TINY, f"agent={agent}")
    assert cli("explore", *words, "loop.episodes=4", "hydra.run.dir=straight").code == 0
    assert cli("explore", *words, "loop.episodes=2", "hydra.run.dir=run").code == 0
    assert cli("resume", "run", "loop.episodes=4").code == 0
    assert rows(tmp_path / "run") == rows(tmp_path / "straight")
    last = rows(tmp_path / "run")[-1]
    assert (last["updates"], last["frames_replayed"], last["unrolls_waiting"]) == (2, 60, 2)
    for name in ("weights.safetensors", "memory.safetensors", "memory.json", "training.safetensors", "rng.json"):
        files = [tmp_path / run / "checkpoint" / "000004" / name for run in ("run", "straight")]
        assert files[0].read_bytes() == files[1].read_bytes(), name
    assert f"| {agent} |" in (tmp_path / "run" / "table.md").read_text()
    refused = cli("explore", *words, "agent.view=ego", "loop.episodes=5", "hydra.run.dir=run")
    assert refused.code == 2 and "agent.view was" in refused.error


@pytest.mark.parametrize("words, said", [
    (["agent.unroll=30"], "agent.unroll=30 does not divide an episode of 20 steps. Set agent.unroll=20"),
    (["agent.reward=novelty"], "agent.reward: 'novelty' is not one of cbet, count, rnd, icm, ride, motion"),
    (["agent.view=front"], "agent.view: 'front' is not one of pano, ego"),
    (["agent.key=grey_8"], "agent.difference: wrapped has no meaning for sums of grey (agent.key=grey_8)"),
    (["agent.reset_prob=2"], "agent.reset_prob: 2.0 is not between 0 and 1"),
    (["agent.environments=0"], "agent.environments: 0 is not between 1 and"),
    (["agent.conv_channels=[]"], "agent.conv_channels: 0 is not between 1 and"),
    (["agent.coefficient.rdn=1"], "no key agent.coefficient.rdn. Did you mean agent.coefficient.rnd"),
    (["agent.name=lbs_dreamer"], "agent.name: 'lbs_dreamer' is not the name of this agent"),
])
def test_wrong_settings_are_answered_in_a_line(cli: Cli, words: list[str], said: str) -> None:
    answer = cli("explore", *TINY, "agent=cbet", *words)
    assert answer.code == 2 and said in answer.error, answer.error
    assert len(answer.error.strip().splitlines()) == 1


def test_without_learning_any_length_of_episode_will_do(cli: Cli) -> None:
    answer = cli("explore", *TINY, "agent=cbet", "loop.steps=7", "loop.iterations=0", "loop.episodes=2")
    assert answer.code == 0, answer.error
