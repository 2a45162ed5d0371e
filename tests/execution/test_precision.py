"""agent.precision in a run: chosen once, written down, kept; what is slow here is said. No speed is measured."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from tiny import LEARNER

from curionav_cli import build
from curionav_cli.agents import arithmetic
from curionav_cli.agents.arithmetic import Rates
from curionav_cli.agents.lbs_dreamer.settings import Precision
from curionav_cli.config.compose import compose
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.schema import Config, Device, Scale
from curionav_cli.config.settings import read_settings
from curionav_cli.config.sources import opened
from curionav_cli.execution.exploration import Exploration, explore
from curionav_cli.execution.precision import with_precision
from curionav_cli.storage.run_folder import RunFolder

SLOW, QUICK = Rates(70, 0.92), Rates(78, 900)


@pytest.fixture(scope="module")
def settings() -> Config:
    """Of a small learner at scale=paper, as shipped: agent.precision=auto."""
    words = [*LEARNER, "scale=paper", "loop.iterations=1", "loop.episodes=1",
             "agent.encoder_channels=[4,4,4,4]", "agent.decoder_channels=[4,4,4]"]
    with opened("explore") as hydra:
        return compose(hydra, OverrideErrors(hydra, words), words)[0]


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Callable[[Rates], None]:
    """machine(rates): with instructions for bfloat16, and as fast as that."""
    def make(rates: Rates) -> None:
        monkeypatch.setattr(arithmetic, "native", lambda: ["amx_bf16"])
        monkeypatch.setattr(arithmetic, "rates", lambda: rates)
    return make


def named(settings: Config, precision: Precision) -> Config:
    return replace(settings, agent=replace(settings.agent, precision=precision))


@pytest.mark.parametrize("scale, rates, chosen", [
    (Scale.paper, QUICK, "bfloat16"), (Scale.paper, SLOW, "float32"), (Scale.cpu, QUICK, "float32"),
])
def test_what_auto_becomes_is_logged_and_never_called_slow(
        settings: Config, machine: Callable[[Rates], None], tmp_path: Path, caplog: pytest.LogCaptureFixture,
        capsys: pytest.CaptureFixture[str], scale: Scale, rates: Rates, chosen: str) -> None:
    machine(rates)
    with caplog.at_level("INFO", logger="curionav"):
        found = with_precision(replace(settings, scale=scale), tmp_path)
    assert found == named(replace(settings, scale=scale), Precision(chosen))
    assert f"agent.precision=auto is {chosen} here (float32 7" in caplog.text and not capsys.readouterr().out


@pytest.mark.parametrize("word, rates, slow", [
    ("bfloat16", SLOW, True), ("float32", QUICK, True), ("float32", SLOW, False), ("bfloat16", QUICK, False),
])
def test_a_named_one_is_obeyed_and_said_to_be_slow(
        settings: Config, machine: Callable[[Rates], None], tmp_path: Path, capsys: pytest.CaptureFixture[str],
        word: str, rates: Rates, slow: bool) -> None:
    machine(rates)
    asked = named(settings, Precision(word))
    assert with_precision(asked, tmp_path) == asked
    assert (f"agent.precision={word} is the slow one" in capsys.readouterr().out) == slow


def test_cuda_is_not_measured(settings: Config, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("torch.cuda.is_available", lambda: True)
    monkeypatch.setattr(arithmetic, "rates", lambda: pytest.fail("measured"))
    on_gpu = replace(settings, device=Device.cuda)
    assert build.automatic(on_gpu) is Precision.bfloat16
    assert with_precision(named(on_gpu, Precision.float32), tmp_path) == named(on_gpu, Precision.float32)


def test_robot_and_server_need_not_choose_alike(settings: Config, machine: Callable[[Rates], None],
                                                tmp_path: Path) -> None:
    shared = []
    for rates in (SLOW, QUICK):
        machine(rates)
        shared.append(Exploration(with_precision(settings, tmp_path), tmp_path).shared)
    assert shared[0] == shared[1] and shared[0]["agent"]["name"] == "lbs_dreamer"


def test_a_run_keeps_its_choice_on_another_machine_which_says_that_it_is_slow(
        settings: Config, machine: Callable[[Rates], None], tmp_path: Path,
        capsys: pytest.CaptureFixture[str]) -> None:
    machine(QUICK)
    explore(settings, tmp_path, drawn=False)
    assert "slow" not in capsys.readouterr().out
    machine(SLOW)
    explore(read_settings(tmp_path / "config.yaml", ["loop.episodes=2"]), tmp_path, drawn=False)  # curionav resume
    explore(replace(settings, loop=replace(settings.loop, episodes=3)), tmp_path, drawn=False)  # typed once more
    line = "agent.precision=bfloat16 is the slow one on this machine (float32 70 GFLOP/s, bfloat16 0.92 GFLOP/s)."
    assert capsys.readouterr().out.count(line) == 2
    run, about = RunFolder(tmp_path), json.loads((tmp_path / "run.json").read_text())
    assert run.settings["agent"]["precision"] == about["precision"] == "bfloat16"
    assert about["gflops"] == QUICK._asdict() and len(run.episode_paths()) == 3
