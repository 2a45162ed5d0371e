"""The two commands of a newcomer, without the installation itself."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="needs make")


def make(*words: str, cwd: Path, **environment: str) -> str:
    outer = ("MAKEFLAGS", "MAKELEVEL", "MFLAGS")  # of the make that runs the tests
    clean = {key: value for key, value in os.environ.items() if key not in outer} | environment
    done = subprocess.run(["make", *words], cwd=cwd, env=clean, capture_output=True, text=True, check=True)
    return done.stdout


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    for name in ("Makefile", "pyproject.toml", "constraints.txt"):
        shutil.copy(ROOT / name, tmp_path)
    return tmp_path


def test_make_alone_prints_the_targets(checkout: Path) -> None:
    out = make(cwd=checkout)
    for target in ("make explore", "make test", "make setup"):
        assert target in out
    assert not (checkout / ".venv").exists()


def test_setup_is_pinned_and_done_once(checkout: Path) -> None:
    first = make("-n", "setup", cwd=checkout)
    assert "-c constraints.txt" in first
    (checkout / ".venv").mkdir()
    (checkout / ".venv" / ".ready").touch()
    assert "pip" not in make("setup", cwd=checkout)
    os.utime(checkout / ".venv" / ".ready", (0, 0))
    assert "pip" in make("-n", "setup", cwd=checkout)


def test_every_figure_says_the_line_that_it_runs(checkout: Path) -> None:
    (checkout / ".venv").mkdir()
    (checkout / ".venv" / ".ready").touch()
    lines = [line for line in make("-n", "figures", "SCALE=smoke", cwd=checkout).splitlines() if "curionav" in line]
    words = [line.split()[:2] for line in lines]
    assert all(line.startswith(".venv/bin/curionav ") for line in lines) and len(lines) == len(set(lines))
    for command, times in (("explore", 4), ("compare", 2), ("coverage", 3), ("sheet", 1), ("dock", 1), ("paper", 4)):
        assert len([one for one in words if one[1] == command]) == times, command
    runs = checkout / "outputs" / "figures" / "smoke" / "runs"
    for name in ("ours", "theirs", "small", "large"):  # whole sweeps are not run again
        (runs / name).mkdir(parents=True)
        (runs / name / ".done").touch()
    assert "explore" not in make("-n", "figures", "SCALE=smoke", cwd=checkout)


def test_the_papers_lengths_are_run_in_the_declared_order(checkout: Path) -> None:
    lines = [line for line in make("-n", "paper-length", cwd=checkout).splitlines() if "curionav explore" in line]
    folders = [Path(line.split("hydra.sweep.dir=")[1]).name for line in lines]
    assert folders[:7] == ["lab", "lab_untrained", "lab_shuffled", "lab_seed_1", "lab_unchanged",
                           "lab_unchanged_untrained", "lab_cbet"]
    assert folders[7:10] == ["apartment_0", "apartment_0_untrained", "apartment_0_cbet"]
    assert folders[-1] == "room" and len(folders) == 17
    assert ["loop.episodes=10000" in line for line in lines] == [name.endswith("_cbet") and name != "lab_cbet"
                                                                 for name in folders]
    assert all(f"env=apartment_{number}" in line for line, name in zip(lines, folders, strict=True)
               for number in name.split("_")[1:2] if name.startswith("apartment"))


def test_what_explorers_teach_is_kept_apart_by_building(checkout: Path) -> None:
    for world, folder in (("env=small_room", "small_room"), ("env=large_lab env.changes=true",
                                                             "large_lab_env.changes_true")):
        lines = make("-n", "teach", f"WORLD={world}", "EXPLORERS=bounce curious_mapper", cwd=checkout)
        here = f"outputs/teach/cpu/{folder}"
        assert f"data={here}/collected/bounce_${{seed}},{here}/collected/curious_mapper_${{seed}}'" in lines
        assert f"hydra.sweep.dir={here}/trained" in lines and f"compare {here}/trained out={here}/compare" in lines


def test_what_the_papers_scale_costs_is_said_before_it_begins(checkout: Path) -> None:
    said = make("-n", "figures", "SCALE=paper", cwd=checkout)
    assert 0 <= said.index("Disk: about") < said.index("curionav explore")


def test_ci_runs_the_tests() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK) and "make test" in script.read_text()


def test_pins_have_no_local_labels() -> None:
    lines = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if not line.startswith("#")]
    assert "torch==2.13.0" in lines
    assert all("==" in line and "+" not in line for line in lines)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_the_pretrained_agent_is_made_and_evaluated(checkout: Path) -> None:
    """Its trial run, with the program of this environment in place of an installation."""
    program = checkout / ".venv" / "bin" / "curionav"
    program.parent.mkdir(parents=True)
    program.write_text(f'#!/bin/sh\nexec {sys.executable} -m curionav_cli "$@"\n')
    program.chmod(0o755)
    (checkout / ".venv" / ".ready").touch()
    environment = {"XDG_CACHE_HOME": str(checkout / "cache"), "PYTHONPATH": str(ROOT)}
    make("pretrained", "SCALE=smoke", cwd=checkout, **environment)
    card = checkout / "cache" / "curionav" / "pretrained" / "apartments_smoke"
    assert (card / "weights.safetensors").stat().st_size < 4e6
    text = (card / "README.md").read_text()
    assert all(f"| apartment_{number} |" in text for number in range(3))
    done = subprocess.run([program, "evaluate", "pretrained=apartments_smoke", "env=small_room", "loop.episodes=1",
                           "loop.steps=100", "hydra.run.dir=run"], cwd=checkout, env={**os.environ, **environment},
                          capture_output=True, text=True)
    assert done.returncode == 0 and (checkout / "run" / "evaluation.md").is_file(), done.stderr
