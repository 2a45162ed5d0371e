"""curionav watch over the folder of a Slurm sweep while it runs, with a stand-in for Slurm's programs."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from cluster import until
from standin_slurm import standin

from curionav_cli.execution.watching.watched import Watched

pytest.importorskip("submitit", reason="needs the extra slurm")
pytestmark = [pytest.mark.slow, pytest.mark.timeout(1200)]
WORDS = ("explore", "-m", "env=small_room", "agent=bounce", "seed=0,1", "loop.episodes=15", "loop.steps=200",
         "launcher=slurm")


def test_runs_are_seen_waiting_running_and_done(tmp_path: Path) -> None:
    sweep, seen = tmp_path / "sweep", []
    with standin(tmp_path / "slurm") as environment:
        sent = subprocess.Popen([sys.executable, "-m", "curionav_cli", *WORDS, f"hydra.sweep.dir={sweep}"],
                                env={**environment, "NO_COLOR": "1"}, text=True, stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE)
        try:
            until(lambda: (sweep / "multirun.yaml").is_file(), "no sweep has begun")
            watched = Watched(sweep)

            def state() -> str:
                seen.append(json.loads(watched.state()))
                return seen[-1]["summary"]
            until(lambda: state() == "2 runs: 2 waiting", "the runs do not wait")
            (tmp_path / "slurm" / "begin").touch()
            until(lambda: state() == "2 runs: 1 running, 1 waiting", "the first run was not seen as it ran")
            until(lambda: state() == "2 runs: 1 done, 1 waiting", "the first run is not done")
            (tmp_path / "slurm" / "free").touch()
            until(lambda: state() == "2 runs: 2 done", "the second run is not done")
            _, error = sent.communicate()
        finally:
            sent.kill()
    assert sent.returncode == 0, error
    names = [run["name"] for run in seen[-1]["runs"]]
    assert names == ["0_small_room_bounce_0", "1_small_room_bounce_1"]
    for name in names:
        assert watched.picture("heatmap", name)[:4] == watched.picture("camera", name)[:4] == b"\x89PNG"
    assert len(list((tmp_path / "slurm").glob("*.state"))) == 2, "both were jobs of the stand-in"
