"""Directories of a user's own: --config-dir and CURIONAV_CONFIG_PATH."""

from __future__ import annotations

from pathlib import Path

import pytest
from entry import Cli

PRESET = "defaults:\n  - sticky\n\nrepeat: 0.9\n"


@pytest.fixture
def own(tmp_path: Path) -> Path:
    folder = tmp_path / "own"
    (folder / "agent").mkdir(parents=True)
    (folder / "agent" / "stubborn.yaml").write_text(PRESET)
    return folder


def test_a_preset_is_found(cli: Cli, own: Path) -> None:
    for option in ("-cd", "--config-dir"):
        answer = cli("explore", option, "own", "agent=stubborn", "--cfg", "job", "-p", "agent")
        assert answer.code == 0 and "repeat: 0.9" in answer.out and "name: sticky" in answer.out


def test_the_path_variable_names_several(cli: Cli, own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    second = own.parent / "second"
    (second / "agent").mkdir(parents=True)
    (second / "agent" / "stubborn.yaml").write_text(PRESET.replace("0.9", "0.1"))
    monkeypatch.setenv("CURIONAV_CONFIG_PATH", f"{own}:{second}")
    answer = cli("explore", "agent=stubborn", "--cfg", "job", "-p", "agent.repeat")
    assert answer.out.strip() == "0.9", answer
    answer = cli("explore", "-cd", "second", "agent=stubborn", "--cfg", "job", "-p", "agent.repeat")
    assert answer.out.strip() == "0.1", "--config-dir ranks before the variable"


def test_a_directory_does_not_outlive_its_command(cli: Cli, own: Path) -> None:
    assert cli("explore", "-cd", "own", "agent=stubborn", "--cfg", "job").code == 0
    assert cli("explore", "agent=stubborn", "--cfg", "job").code == 2


def test_an_option_of_ones_own_is_suggested(cli: Cli, own: Path) -> None:
    answer = cli("explore", "-cd", "own", "agent=stuborn")
    assert "Did you mean stubborn?" in answer.error


def test_a_missing_directory(cli: Cli) -> None:
    answer = cli("explore", "-cd", "nowhere")
    assert answer.code == 2
    assert answer.error.strip() == "--config-dir: there is no directory nowhere. Name one that exists."


WRONG = {
    "repeet: 0.9": ["the settings have no key agent.repeet. Did you mean agent.repeat?"],
    "repeat: often": ["agent.repeat: 'often' is not a number."],
    "repeat: [": ["line", "this is not YAML"],
    "repeat: 7": ["agent.repeat: 7.0 is not between 0 and 1"],
}


@pytest.mark.parametrize("line", WRONG)
def test_a_wrong_file_is_named(cli: Cli, own: Path, line: str) -> None:
    file = own / "agent" / "stubborn.yaml"
    file.write_text(PRESET.replace("repeat: 0.9", line))
    answer = cli("explore", "-cd", "own", "agent=stubborn")
    assert answer.code == 2 and len(answer.error.strip().splitlines()) <= 4
    for piece in WRONG[line]:
        assert piece in answer.error
    if line != "repeat: 7":
        assert str(file) in answer.error


def test_a_config_cannot_name_a_callable(cli: Cli, own: Path, tmp_path: Path) -> None:
    (own / "agent" / "stubborn.yaml").write_text(PRESET + "_target_: os.mkdir\n_args_: [stolen]\n")
    answer = cli("explore", "-cd", "own", "agent=stubborn")
    assert answer.code == 2 and not (tmp_path / "stolen").exists()


def test_a_sweep_that_is_no_list_of_values(cli: Cli, own: Path) -> None:
    (own / "experiment").mkdir(exist_ok=True)
    (own / "experiment" / "odd.yaml").write_text(
        "# @package _global_\nhydra:\n  mode: MULTIRUN\n  sweeper:\n    params:\n      seed: {a: b}\n")
    answer = cli("explore", "-cd", str(own), "experiment=odd", "agent=random")
    assert answer.code == 2 and "hydra.sweeper.params: each is a list of values" in answer.error
    assert len(answer.error.strip().splitlines()) == 1


def test_a_sweep_is_resumed_with_all_directories_that_it_began_with(
        cli: Cli, own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (own.parent / "other" / "experiment").mkdir(parents=True)
    (own.parent / "other" / "experiment" / "two.yaml").write_text(
        "# @package _global_\ndefaults:\n  - override /agent: stubborn\nloop: {steps: 5, episodes: 1}\n")
    monkeypatch.setenv("CURIONAV_CONFIG_PATH", str(own))
    words = ("-m", "-cd", "other", "experiment=two", "seed=0,1", "hydra.sweep.dir=sweep")
    assert cli("explore", *words).code == 0
    monkeypatch.delenv("CURIONAV_CONFIG_PATH")
    answer = cli("resume", "sweep", "loop.episodes=2")
    assert answer.code == 0, answer.error
