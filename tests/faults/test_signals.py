"""SIGTERM: a run notes it, exits with 143 within ten seconds, and goes on as if nothing had been."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from curionav_cli.storage.run_folder import RunFolder

WORDS = ("agent=random", "env=small_room", "loop.steps=40", "loop.episodes=100000")


def begun(*words: str) -> subprocess.Popen[str]:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}
    return subprocess.Popen([sys.executable, "-m", "curionav_cli", "explore", *words], env=environment, text=True,
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def wait_for_an_episode(run: RunFolder) -> None:
    """Wait until the run has finished an episode."""
    while not run.path.is_dir() or run.status.get("episode", 0) < 1:
        time.sleep(0.05)


def stopped(process: subprocess.Popen[str]) -> str:
    """Its last words. The ten seconds are those of a quiet machine; tests may run on a busy one."""
    process.send_signal(signal.SIGTERM)
    _, error = process.communicate(timeout=120)
    assert process.returncode == 143, error
    return error


def test_a_run_ends_with_143_and_goes_on(tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    process = begun(*WORDS, f"hydra.run.dir={run.path}")
    wait_for_an_episode(run)
    error = stopped(process)
    assert error == f"Stopped by SIGTERM. To go on: curionav resume {run.path}\n"
    assert run.state == "interrupted" and run.status["error"] == "stopped by SIGTERM"
    parts = [path for path in run.path.rglob("*.part") if path.parent != run.checkpoints]
    assert not parts, "a checkpoint that was being saved is no checkpoint, and the next one takes its place"


@pytest.mark.faults
def test_a_sweep_takes_its_workers_with_it(tmp_path: Path) -> None:
    process = begun("-m", *WORDS, "seed=0,1", "launcher=cores", f"hydra.sweep.dir={tmp_path}")
    runs = [RunFolder(tmp_path / f"{seed}_small_room_random_{seed}") for seed in (0, 1)]
    for run in runs:
        wait_for_an_episode(run)
    assert f"curionav resume {tmp_path}" in stopped(process)
    end = time.monotonic() + 60
    while any(run.in_use for run in runs) and time.monotonic() < end:
        time.sleep(0.1)
    assert [run.state for run in runs] == ["interrupted"] * 2
