"""curionav dock from the prompt: a handful of returns to dock, their tables, a killed run that goes on, wrong words."""

from __future__ import annotations

import csv
import json
import shutil
import signal
from pathlib import Path

import pytest
from entry import Cli
from warm import Warm

from curionav_cli.results.docking import counted
from curionav_cli.storage.run_folder import RunFolder

unseen = pytest.mark.usefixtures("blank_figures")
SMALL = ("dock", "env=small_room", "loop.steps=25")

# Kills its own process after the seventh request's line, as a power cut would.
KILLED = """
from curionav_cli.execution import docking_trial
import os, signal
from curionav_cli import app

from curionav_cli.storage.run_folder import RunFolder
docking_trial.EVERY, plain = 3, RunFolder.append_metrics
def append(run, row):
    plain(run, row)
    if row["episode"] == 4: os.kill(os.getpid(), signal.SIGKILL)
RunFolder.append_metrics = append
app.main()
"""


@pytest.mark.usefixtures("painted")
def test_the_table_counts_every_request(cli: Cli, tmp_path: Path) -> None:
    answer = cli(*SMALL, "dock.requests=3", "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    assert "request 3/3" in answer.out and "carried" in answer.out
    rows = [json.loads(line) for line in (tmp_path / "run" / "metrics.jsonl").read_text().splitlines()]
    assert [row["episode"] for row in rows] == [0, 1, 2]
    with open(tmp_path / "run" / "results.csv") as file:
        (result,) = csv.DictReader(file)
    docked = sum(row["code"] == "docked" for row in rows)
    assert (int(result["requests"]), int(result["docked"]), int(result["human"])) == (3, docked, 3 - docked)
    assert float(result["ratio_low"]) <= docked / 3 <= float(result["ratio_high"])
    with open(tmp_path / "run" / "endings.csv") as file:
        assert sum(int(row["count"]) for row in csv.DictReader(file)) == 3
    assert (tmp_path / "run" / "figures" / "arrivals.png").stat().st_size > 5000
    assert not list((tmp_path / "run" / "episodes").iterdir())


@unseen
def test_a_finished_run_returns_at_once_and_may_become_longer(cli: Cli, tmp_path: Path) -> None:
    assert cli(*SMALL, "dock.requests=2", "hydra.run.dir=run").code == 0
    again = cli("resume", "run")
    assert again.code == 0 and "run: is done already" in again.out and "request" not in again.out.split("requests")[0]
    assert "2/2" in cli("runs", "run").out
    assert cli("resume", "run", "dock.requests=3").code == 0 and "3/3" in cli("runs", "run").out


@pytest.mark.slow
@unseen
def test_only_what_differs_in_nothing_but_its_seed_is_counted_together(cli: Cli, tmp_path: Path) -> None:
    words = (*SMALL, "dock.requests=1", "seed=0,1", "robot.docking.attempt=20,48", "hydra.sweep.dir=sweep")
    assert cli(words[0], "-m", *words[1:]).code == 0
    with open(tmp_path / "sweep" / "results.csv") as file:
        rows = list(csv.DictReader(file))
    assert [(row["seed"], row["requests"]) for row in rows[4:]] == [("2 seeds", "2")] * 2
    assert {row["robot"] for row in rows[4:]} == {"turtlebot2i attempt=20.0", "turtlebot2i attempt=48.0"}
    assert len(list((tmp_path / "sweep" / "figures").glob("arrivals_*.png"))) == 2
    shutil.copytree(tmp_path / "sweep", tmp_path / "twice" / "a")  # the same seed twice is one
    runs = [RunFolder(path) for part in ("sweep", "twice/a") for path in sorted(tmp_path.glob(f"{part}/[0-9]*"))]
    each, together = counted(runs)
    assert len(each) == 8 and [(one.where["seed"], len(one.docks)) for one in together] == [("2 seeds", 2)] * 2


@unseen
def test_a_killed_run_goes_on_to_the_same_returns_to_dock(cli: Cli, warm: Warm, tmp_path: Path) -> None:
    words = [*SMALL, "dock.requests=6"]
    assert cli(*words, "hydra.run.dir=whole").code == 0
    ended = warm(*words, "hydra.run.dir=torn", program=KILLED, cwd=tmp_path)
    assert ended.returncode == -signal.SIGKILL, ended.stderr
    assert sorted(path.name for path in (tmp_path / "torn" / "checkpoint").iterdir()) == ["000000", "000003"]
    assert cli("resume", "torn").code == 0
    same = [(tmp_path / run / "metrics.jsonl").read_bytes() for run in ("whole", "torn")]
    assert same[0] == same[1]
    shutil.rmtree(tmp_path / "torn")


@unseen
def test_the_folder_of_another_command_is_refused(cli: Cli) -> None:
    assert cli("explore", "agent=random", "loop.steps=5", "loop.episodes=1", "hydra.run.dir=explored").code == 0
    answer = cli("dock", "env=small_room", "dock.requests=1", "hydra.run.dir=explored")
    assert answer.code == 2 and "cannot go on with other settings" in answer.error
    assert len(answer.error.strip().splitlines()) == 1


@pytest.mark.parametrize(("words", "says"), [
    (("robot=ideal",), "robot=turtlebot2i"), (("dock.requests=0",), "dock.requests"), (("dock.request=3",), "requests"),
])
def test_wrong_words_are_answered_before_anything_runs(cli: Cli, tmp_path: Path, words: tuple[str, ...],
                                                       says: str) -> None:
    answer = cli("dock", *words)
    assert answer.code == 2 and says in answer.error and "Traceback" not in answer.error
    assert not (tmp_path / "outputs").exists()
