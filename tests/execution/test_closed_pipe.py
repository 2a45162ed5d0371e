"""What is piped into head: it ends quietly when that has gone, and a run can be resumed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from curionav_cli.errors import Unread
from curionav_cli.execution.interrupts import UNREAD, ended
from curionav_cli.execution.screen import Screen
from curionav_cli.storage.run_folder import RunFolder

RUN = ("agent=random", "env=small_room", "loop.steps=5", "loop.episodes=100000")


def until_first_line(folder: Path, *words: str) -> tuple[str, int, str]:
    """What `curionav WORDS | head -1` shows, with the exit code and the standard error of curionav."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}
    with subprocess.Popen([sys.executable, "-m", "curionav_cli", *words], cwd=folder, env=environment, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout and process.stderr
        first = process.stdout.readline()
        process.stdout.close()
        error = process.stderr.read()
    return first, process.returncode, error


def test_a_run_is_interrupted_and_goes_on(tmp_path: Path) -> None:
    first, code, error = until_first_line(tmp_path, "explore", *RUN, "hydra.run.dir=run")
    assert "episode 1/" in first and (code, error) == (141, "")
    run = RunFolder(tmp_path / "run")
    assert (run.state, run.status["error"]) == ("interrupted", UNREAD)
    first, code, error = until_first_line(tmp_path, "resume", "run")
    assert first.startswith("run: goes on after ") and (code, error) == (141, "")


@pytest.mark.faults
def test_a_sweep_ends_with_all_its_runs(tmp_path: Path) -> None:
    words = ("explore", "-m", *RUN, "seed=0,1", "launcher=cores", "hydra.sweep.dir=sweep")
    _, code, error = until_first_line(tmp_path, *words)
    assert code == 141 and "Traceback" not in error
    runs = RunFolder.inside(tmp_path / "sweep")
    assert runs and {run.state for run in runs} == {"interrupted"}


def test_a_closed_pipe_is_no_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("curionav_cli.execution.interrupts.mute", lambda: None)
    run = RunFolder(tmp_path)
    assert type(ended(run, BrokenPipeError(32, "Broken pipe"))) is Unread
    assert run.status == {"state": "interrupted", "error": UNREAD}


def test_a_table_does_not_end_the_process_behind_our_back() -> None:
    with pytest.raises(Unread):
        Screen().on_broken_pipe()


@pytest.mark.parametrize("words", [("--help",), pytest.param(("explore", "--help"), marks=pytest.mark.slow),
                                   ("list", "agent")])
def test_what_nobody_reads_at_all_is_no_failed_run(words: tuple[str, ...]) -> None:
    unread, stdout = os.pipe()
    os.close(unread)
    with os.fdopen(stdout, "w") as closed:
        answer = subprocess.run([sys.executable, "-m", "curionav_cli", *words], stdout=closed, stderr=subprocess.PIPE)
    assert (answer.returncode, answer.stderr) == (141, b"")
