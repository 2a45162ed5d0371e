"""A sweep of six runs on a real Slurm: one is preempted and goes on, one fails, and the table says so."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from cluster import answer, available, cluster, until
from leftovers import leftovers
from tiny import LEARNER

from curionav_cli.storage.run_folder import RunFolder

pytest.importorskip("submitit", reason="needs the extra slurm")
pytestmark = [
    pytest.mark.slurm, pytest.mark.timeout(3600),
    pytest.mark.skipif(not available(), reason="needs root, slurmctld, slurmd, slurm-client and munge"),
]
LONG = [*(word for word in LEARNER if not word.startswith("loop.episodes")), "loop.episodes=40"]
BUSY = 1000.0  # seconds within which a machine with other work gets to it
QUEUE = ["launcher=slurm", "hydra.launcher.mem_gb=1", "seed=range(6)"]


@pytest.fixture
def slurm() -> Iterator[dict[str, str]]:
    with cluster() as environment:
        yield environment | {"NO_COLOR": "1", "OMP_NUM_THREADS": "1"}


@contextmanager
def curionav(environment: dict[str, str], *words: str) -> Iterator[subprocess.Popen[str]]:
    """As a terminal starts it: tests that run in the background have their Ctrl-C taken away by the shell."""
    with subprocess.Popen([sys.executable, "-m", "curionav_cli", *words], env=environment, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)) as process:
        try:
            yield process
        finally:
            process.kill()


def test_six_runs(slurm: dict[str, str], tmp_path: Path) -> None:
    sweep = tmp_path / "sweep"
    runs = [RunFolder(sweep / f"{seed}_small_room_lbs_dreamer_{seed}") for seed in range(6)]
    runs[5].path.mkdir(parents=True)
    (runs[5].path / "checkpoint").write_text("in the way")
    with curionav(slurm, "explore", "-m", *LONG, *QUEUE, f"hydra.sweep.dir={sweep}") as sent:
        until(lambda: runs[0].status.get("episode", 0) >= 2 or sent.poll() is not None, "no first episode", BUSY)
        urgent = subprocess.run(["sbatch", "-p", "urgent", "-n", "2", "-o", "/dev/null", "--wrap", "sleep 1"],
                                env=slurm, capture_output=True, text=True, check=True)
        assert "Submitted" in urgent.stdout
        out, error = sent.communicate()
    assert sent.returncode == 1, error
    assert "goes on after" in text(runs[0], sweep), "it was preempted, and put back by Slurm"
    assert [run.state for run in runs] == ["done"] * 5 + ["failed"]
    assert "5_small_room_lbs_dreamer_5: FileExistsError" in error and "in the way" not in out
    assert "FileExistsError" in runs[5].status["error"]
    table = (sweep / "table.md").read_text()
    assert table.count("| done |") == 5 and table.count("| failed |") == 1
    assert json.loads((runs[0].path / "run.json").read_text())["threads"] == "1"
    with curionav(slurm, "explore", *LONG, "seed=0", f"hydra.run.dir={tmp_path / 'alone'}") as alone:
        alone.communicate()
    assert alone.returncode == 0
    ours, theirs = leftovers(runs[0].path), leftovers(tmp_path / "alone")
    assert ours.keys() == theirs.keys() and [name for name in ours if ours[name] != theirs[name]] == []


def text(run: RunFolder, sweep: Path) -> str:
    """What the job of a run has printed."""
    number = run.path.name.partition("_")[0]
    return "".join(path.read_text() for path in sweep.glob(f".submitit/*/*_{number}_0_log.out"))


def test_ctrl_c_says_how_to_stop_the_jobs(slurm: dict[str, str], tmp_path: Path) -> None:
    sweep = tmp_path / "sweep"
    words = ("explore", "-m", *LONG[:-1], "loop.episodes=4000", *QUEUE, f"hydra.sweep.dir={sweep}")
    with curionav(slurm, *words) as sent:
        until(lambda: list(sweep.glob("*/status.json")) or sent.poll() is not None, "no run began", BUSY)
        os.kill(sent.pid, signal.SIGINT)
        _, error = sent.communicate()
    assert sent.returncode == 130
    line = next(line for line in error.splitlines() if "scancel" in line)
    job = line.rpartition("scancel ")[2]
    assert job in answer(["squeue", "-h", "-o", "%A %F"], slurm)
    assert f"curionav resume {sweep}" in error
    subprocess.run(["scancel", job], env=slurm, check=True)
    until(lambda: not answer(["squeue", "-h"], slurm).strip(), "the jobs were not stopped", BUSY)
