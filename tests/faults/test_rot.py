"""Truncated and flipped files: found by their checksums and named; sound ones are used. Two processes, a clock."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from forked import Forks
from leftovers import leftovers
from tiny import LEARNER

from curionav_cli.storage.run_folder import RunFolder

Harm = Callable[[bytes, np.random.Generator], bytes]


def torn(body: bytes, rng: np.random.Generator) -> bytes:
    return body[:int(rng.integers(0, len(body)))]


def flipped(body: bytes, rng: np.random.Generator) -> bytes:
    """One bit of it is another one."""
    array = np.frombuffer(body, np.uint8).copy()
    array[rng.integers(len(array))] ^= 1 << rng.integers(8)
    return array.tobytes()


HARMS = (torn, flipped)
LONGER = "loop.episodes=5"


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory, forks: Forks) -> tuple[Path, dict[str, Any]]:
    """A finished run of four episodes, and what is left of it after a fifth."""
    folder = tmp_path_factory.mktemp("runs")
    assert forks("explore", *LEARNER, f"hydra.run.dir={folder / 'run'}").code == 0
    shutil.copytree(folder / "run", folder / "longer")
    assert forks("resume", str(folder / "longer"), LONGER).code == 0
    return folder / "run", leftovers(folder / "longer")


def harmed(runs: tuple[Path, dict[str, Any]], name: str, harm: Harm, folder: Path, seed: int = 0) -> Path:
    """A copy of the run with one file broken."""
    shutil.copytree(runs[0], folder)
    path = folder / name
    path.write_bytes(harm(path.read_bytes(), np.random.default_rng(seed)))
    return folder


@pytest.mark.parametrize("harm", [torn, pytest.param(flipped, marks=pytest.mark.faults)])
@pytest.mark.parametrize("name", [
    "checkpoint/000004/weights.safetensors",
    *(pytest.param(name, marks=pytest.mark.faults) for name in (
        "checkpoint/000004/training.safetensors", "checkpoint/000004/training.json", "checkpoint/000004/rng.json",
        "checkpoint/000004/settings.json", "checkpoint/000004/checksums.json", "episodes/000003.npz", "status.json")),
])
def test_the_run_goes_back_to_what_is_sound(
        tmp_path: Path, forks: Forks, runs: tuple[Path, dict[str, Any]], name: str, harm: Harm) -> None:
    run = harmed(runs, name, harm, tmp_path / "run")
    answer = forks("resume", str(run), LONGER)
    assert answer.code == 0, answer.error
    assert f"{run / name} " in answer.error, "it is named"
    ours = leftovers(run)
    assert ours.keys() == runs[1].keys() and [key for key in ours if ours[key] != runs[1][key]] == []


@pytest.mark.faults
@pytest.mark.parametrize("harm", HARMS)
@pytest.mark.parametrize("name", ["episodes/000001.npz", "plan.npz", "fixed.json", "config.yaml", "run.json"])
def test_what_cannot_be_mended_is_refused_by_name(
        tmp_path: Path, forks: Forks, runs: tuple[Path, dict[str, Any]], name: str, harm: Harm) -> None:
    """Or it is sound enough that nothing changes: a bit of a comment, of a zip's date."""
    for seed in range(6):
        run = harmed(runs, name, harm, tmp_path / str(seed), seed)
        answer = forks("resume", str(run), LONGER)
        if answer.code == 0:
            ours = leftovers(run)
            assert [key for key in ours if ours[key] != runs[1][key] and key != name] == []
            continue
        assert answer.code == 2 and len(answer.error.strip().splitlines()) <= 2, answer.error
        assert str(run) in answer.error and "Traceback" not in answer.error


def test_a_second_process_is_refused_in_one_line(tmp_path: Path, forks: Forks) -> None:
    run = RunFolder(tmp_path / "run")
    with run.locked():
        answer = forks("explore", "agent=random", "loop.steps=5", "loop.episodes=1", f"hydra.run.dir={run.path}")
    assert answer.code == 2 and not answer.out
    assert [path.name for path in run.path.iterdir()] == [".lock"], "nothing was written into the other's folder"
    assert answer.error == f"{run.path} is in use by process {os.getpid()} on {os.uname().nodename}. " \
                         "Wait for it, or stop it.\n"


def test_a_clock_that_is_put_back_changes_nothing(tmp_path: Path, forks: Forks, runs: tuple[Path, dict]) -> None:
    """Files from the future: nothing goes by their dates."""
    run = tmp_path / "run"
    shutil.copytree(runs[0], run)
    for number, path in enumerate(sorted(run.rglob("*"), reverse=True)):
        os.utime(path, (time.time() + 1e6 + number,) * 2)
    assert forks("resume", str(run), LONGER).code == 0
    ours = leftovers(run)
    assert [key for key in ours if ours[key] != runs[1][key]] == []
