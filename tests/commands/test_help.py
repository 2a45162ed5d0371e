"""Help, version, and what is shown instead of run."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from entry import Cli

import curionav_cli
from curionav_cli.config.sources import conf_dir

HEAVY = ("torch", "numpy", "scipy", "hydra", "omegaconf", "gymnasium", "cv2", "matplotlib", "yaml")


@pytest.mark.parametrize("words", [["--help"], ["--version"]])
def test_nothing_heavy_is_imported_for_help(words: list[str]) -> None:
    code = (f"import sys\nfrom curionav_cli.app import main\ntry:\n    main({words})\nfinally:\n"
            f"    print('LOADED', [name for name in {HEAVY} if name in sys.modules])")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "LOADED []" in done.stdout


def test_who_does_not_learn_needs_no_torch(tmp_path: Path) -> None:
    """A whole run with its figures, and neither what learners, docking robots nor comparisons need."""
    unused = ("torch", "scipy.stats", "scipy.sparse.csgraph", "curionav_cli.robot.env")
    words = ["explore", "agent=random", "loop.episodes=1", "loop.steps=5", f"hydra.run.dir={tmp_path}"]
    code = (f"import sys\nfrom curionav_cli.app import main\ntry:\n    main({words})\nfinally:\n"
            f"    print('LOADED', [name for name in {unused} if name in sys.modules])")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "LOADED []" in done.stdout and (tmp_path / "figures" / "heatmap.png").is_file()


def test_version(cli: Cli) -> None:
    assert cli("--version").out.strip() == f"curionav {curionav_cli.__version__}"


def test_the_module_runs_too() -> None:
    done = subprocess.run([sys.executable, "-m", "curionav_cli", "--version"], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.startswith("curionav ")


def test_help_names_the_commands(cli: Cli) -> None:
    for words in (["--help"], ["-h"]):
        answer = cli(*words)
        assert answer.code == 0
        for command in ("explore", "resume", "train", "dock", "coverage", "compare"):
            assert command in answer.out
    assert "explore" in cli().out


def test_help_of_explore_names_every_choice_and_setting(cli: Cli) -> None:
    for words in (["--help"], ["-h"]):
        out = cli("explore", *words).out
        for path in conf_dir().glob("*/*.yaml"):
            assert path.stem in out
        for line in ("loop.steps", "500", "agent.gru_units", "env.collision", "*small_room", "*lbs_dreamer"):
            assert line in out
        choices = out.partition("Choices")[2]
        assert "schema" not in choices and "hydra" not in choices


def test_help_of_a_chosen_agent_shows_its_settings_and_their_choices(cli: Cli) -> None:
    out = cli("explore", "agent=cbet", "--help").out
    assert "*pano, ego" in out and "agent.gru_units" not in out
    assert "*lbs, picture_count" in cli("explore", "--help").out


def test_cfg_shows_a_part_and_resolves(cli: Cli) -> None:
    answer = cli("explore", "agent=bounce", "--cfg", "job", "-p", "agent")
    assert answer.out == "# @package agent\nname: bounce\nmin_turn: 30.0\nmax_turn: 180.0\n"
    assert "seed: 500" in cli("explore", "seed=${loop.steps}", "--cfg", "job", "--resolve").out
    assert "launcher" in cli("explore", "--cfg", "hydra").out
    everything = cli("explore", "--cfg", "all").out
    assert "seed: 0" in everything and "launcher" in everything


def test_cfg_of_a_sweep_shows_each_job(cli: Cli) -> None:
    out = cli("explore", "-m", "agent=random", "seed=4,5", "--cfg", "job").out
    assert out.count("---\n") == 2 and "seed: 4" in out and "seed: 5" in out


@pytest.mark.parametrize("words", [[], ["searchpath"], ["agent=bounce"], ["config", "agent=bounce"]])
def test_info(cli: Cli, words: list[str]) -> None:
    answer = cli("explore", "--info", *words)
    assert answer.code == 0 and str(conf_dir()) in answer.out
    assert ("min_turn" in answer.out) == ("agent=bounce" in words)


def test_a_wrong_kind_of_cfg(cli: Cli) -> None:
    assert cli("explore", "--cfg", "jobs").code == 2
