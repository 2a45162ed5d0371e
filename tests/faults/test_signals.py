"""SIGTERM: a run notes it, exits with 143 within ten seconds, and goes on as if nothing had been."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest

from curionav_cli.storage.run_folder import RunFolder

WORDS = ("agent=random", "env=small_room", "loop.steps=40", "loop.episodes=100000")


@contextmanager
def begun(*words: str) -> Iterator[subprocess.Popen[str]]:
    """The process of a run or a sweep; whatever the test finds, it and its workers are gone at the end."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}
    with subprocess.Popen([sys.executable, "-m", "curionav_cli", "explore", *words], env=environment, text=True,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True) as process:
        try:
            yield process
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def wait_for_an_episode(run: RunFolder, process: subprocess.Popen[str]) -> None:
    """Wait until the run has finished an episode."""
    while not run.path.is_dir() or run.status.get("episode", 0) < 1:
        assert process.poll() is None, process.communicate()[1]
        time.sleep(0.05)


def stopped(process: subprocess.Popen[str]) -> str:
    """Its last words. The ten seconds are those of a quiet machine; tests may run on a busy one."""
    process.send_signal(signal.SIGTERM)
    _, error = process.communicate()
    assert process.returncode == 143, error
    return error


def test_a_run_ends_with_143_and_goes_on(tmp_path: Path) -> None:
    run = RunFolder(tmp_path / "run")
    with begun(*WORDS, f"hydra.run.dir={run.path}") as process:
        wait_for_an_episode(run, process)
        error = stopped(process)
    assert error == f"Stopped by SIGTERM. To go on: curionav resume {run.path}\n"
    assert run.state == "interrupted" and run.status["error"] == "stopped by SIGTERM"
    parts = [path for path in run.path.rglob("*.part") if path.parent != run.checkpoints]
    assert not parts, "a checkpoint that was being saved is no checkpoint, and the next one takes its place"


@pytest.mark.faults
def test_a_sweep_takes_its_workers_with_it(tmp_path: Path) -> None:
    runs = [RunFolder(tmp_path / f"{seed}_small_room_random_{seed}") for seed in (0, 1)]
    with begun("-m", *WORDS, "seed=0,1", "launcher=cores", f"hydra.sweep.dir={tmp_path}") as process:
        for run in runs:
            wait_for_an_episode(run, process)
        assert f"curionav resume {tmp_path}" in stopped(process)
        while any(run.in_use for run in runs):  # until the workers have seen it, or this test's time is over
            time.sleep(0.1)
    assert [run.state for run in runs] == ["interrupted"] * 2
