"""curionav runs: what is in outputs/, chosen and sorted; curionav init; curionav resume of a sweep."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest
from entry import Cli

from curionav_cli.commands import explore
from curionav_cli.config.compose import plan
from curionav_cli.config.sources import opened
from curionav_cli.storage.run_folder import RunFolder

pytestmark = pytest.mark.usefixtures("blank_figures")
CONFIG = "env: {name: %s}\nagent: {name: %s}\nrobot: {name: ideal}\nseed: %d\n"


def a_run(path: Path, env: str = "small_room", agent: str = "random", seed: int = 0, size: int = 0,
          **status: object) -> Path:
    path.mkdir(parents=True)
    (path / "config.yaml").write_text(CONFIG % (env, agent, seed))
    (path / "run.json").write_text("{}")
    (path / "weight").write_bytes(os.urandom(size))
    RunFolder(path).set_status(**status)
    return path


@pytest.fixture
def outputs(tmp_path: Path) -> Path:
    """A single run, and a sweep of three; the first is the oldest."""
    out = tmp_path / "outputs"
    a_run(out / "day" / "old", state="done", episode=3, episodes=3, coverage=0.25)
    a_run(out / "day" / "sweep" / "0", agent="bounce", size=3_000_000, state="failed", episode=1, episodes=3,
          coverage=0.5, error="the disk is full")
    a_run(out / "day" / "sweep" / "1", seed=7, state="running", episode=2, episodes=3, coverage=0.125)
    a_run(out / "day" / "sweep" / "2", env="large_lab", state="done", iteration=9, iterations=9)
    for path in (out / "day" / "old").rglob("*"):
        os.utime(path, (0, time.time() - 90000))
    os.utime(out / "day" / "old", (0, time.time() - 90000))
    return out


def names(out: str) -> list[str]:
    return [line.split()[0].removeprefix("outputs/day/") for line in out.splitlines() if line.startswith(" outputs/")]


def test_every_run_the_newest_first(cli: Cli, outputs: Path) -> None:
    answer = cli("runs")
    assert answer.code == 0, answer.error
    assert set(names(answer.out)) == {"old", "sweep/0", "sweep/1", "sweep/2"} and names(answer.out)[-1] == "old"
    line = next(line for line in answer.out.splitlines() if "day/old" in line)
    assert line.split()[1:6] == ["1", "d", "01", "h", "done"], "by what it is sorted comes first"
    assert line.split()[6] == "25.0%" and line.split()[-4:] == ["3/3", "small_room", "random", "0"]
    assert "outputs/day/sweep/0: the disk is full" in answer.out and "4 runs, 3." in answer.out


def test_what_was_asked_for_is_shown_first(cli: Cli, outputs: Path) -> None:
    out = cli("runs", "agent=random", "sort=size").out
    heads = next(line for line in out.splitlines() if line.startswith(" run"))
    assert heads.split()[:4] == ["run", "agent", "size", "state"]


@pytest.mark.parametrize(("words", "expected"), [
    (["state=done", "sort=run"], ["old", "sweep/2"]),
    (["state=interrupted"], ["sweep/1"]),  # it says running, and has no process
    (["agent=bounce"], ["sweep/0"]),
    (["env=large_lab"], ["sweep/2"]),
    (["seed=7"], ["sweep/1"]),
    (["sort=coverage"], ["sweep/0", "old", "sweep/1", "sweep/2"]),
    (["sort=size", "state=failed"], ["sweep/0"]),
    (["outputs/day/sweep", "sort=run"], ["sweep/0", "sweep/1", "sweep/2"]),
    (["seed=9"], []),
])
def test_chosen_and_sorted(cli: Cli, outputs: Path, words: list[str], expected: list[str]) -> None:
    answer = cli("runs", *words)
    assert answer.code == 0 and names(answer.out) == expected
    assert expected or "matches" in answer.out


def test_a_run_in_use_is_running(cli: Cli, outputs: Path) -> None:
    with RunFolder(outputs / "day" / "sweep" / "1").locked():
        assert names(cli("runs", "state=running").out) == ["sweep/1"]


def test_what_is_broken_is_named_and_the_rest_is_shown(cli: Cli, outputs: Path) -> None:
    (outputs / "day" / "old" / "status.json").write_text('{"state": "done"')
    flipped = outputs / "day" / "sweep" / "2" / "status.json"
    flipped.write_text(flipped.read_text().replace("9", "8", 1))
    answer = cli("runs", "state=broken")
    assert set(names(answer.out)) == {"old", "sweep/2"}
    assert "sweep/2/status.json cannot be read (its checksum is another one)" in answer.out
    assert len(names(cli("runs").out)) == 4


def test_a_clock_that_was_put_back(cli: Cli, outputs: Path) -> None:
    for path in (outputs / "day" / "old").rglob("*"):
        os.utime(path, (0, time.time() + 1e6))
    assert "0 min 00 s" in cli("runs", "outputs/day/old").out


def test_where_there_is_nothing(cli: Cli, tmp_path: Path) -> None:
    answer = cli("runs")
    assert answer.code == 2 and answer.error.startswith("There is no folder outputs.")
    (tmp_path / "outputs").mkdir()
    assert cli("runs").out.strip() == "No run in outputs."
    answer = cli("runs", "sort=colour")
    assert answer.code == 2 and "sort: 'colour' is not one of age, coverage" in answer.error


def test_a_directory_of_ones_own_runs_as_it_is(cli: Cli, unsized: None, tmp_path: Path) -> None:
    made = cli("init", "mine")
    assert made.code == 0 and "curionav explore -cd mine experiment=my_sweep" in made.out
    for what, word in (("env", "env=my_room"), ("agent", "agent=my_agent")):
        shown = cli("explore", "-cd", "mine", word, "--cfg", "job", "-p", what)
        assert shown.code == 0, shown.error
    with opened("explore", tmp_path / "mine") as hydra:
        assert len(plan(hydra, ["experiment=my_sweep"], multirun=False, check=explore.check).jobs) == 6
    answer = cli("explore", "-cd", "mine", "experiment=my_sweep", "hydra.sweeper.params.agent=sticky", "loop.steps=9",
                 "hydra.sweep.dir=sweep")
    assert answer.code == 0, answer.error
    assert [run.state for run in RunFolder.inside(tmp_path / "sweep")] == ["done", "done"]
    assert "my_room" in cli("list", "env", "-cd", "mine").out


def test_nothing_of_ones_own_is_written_over(cli: Cli, tmp_path: Path) -> None:
    (tmp_path / "mine" / "env").mkdir(parents=True)
    (tmp_path / "mine" / "env" / "my_room.yaml").write_text("precious")
    answer = cli("init", "mine")
    assert answer.code == 2 and "mine/env/my_room.yaml exists already" in answer.error
    assert not (tmp_path / "mine" / "agent").exists()
    (tmp_path / "file").write_text("")
    assert cli("init", "file").code == 2


SWEEP = ("agent=random", "loop.steps=5", "loop.episodes=2", "hydra.sweep.dir=sweep")


def test_a_sweep_goes_on(cli: Cli, tmp_path: Path) -> None:
    """What is done is left alone, what was interrupted goes on, what failed only when asked."""
    failing = tmp_path / "sweep" / "2_small_room_random_2"
    failing.mkdir(parents=True)
    (failing / "episodes").write_text("in the way")
    answer = cli("explore", "-m", *SWEEP, "seed=0,1,2")
    assert answer.code == 1 and "curionav resume sweep --failed" in answer.out
    (failing / "episodes").unlink()
    done, stopped = (RunFolder(tmp_path / "sweep" / f"{n}_small_room_random_{n}") for n in (0, 1))
    stopped.set_status(state="running")
    before = [path.stat().st_mtime_ns for path in done.episode_paths()]
    again = cli("resume", "sweep")
    assert again.code == 1 and "failed before" in again.error
    assert "1_small_room_random_1: goes on after 2 finished episodes" in again.out
    assert stopped.state == "done" and RunFolder(failing).state == "failed"
    assert [path.stat().st_mtime_ns for path in done.episode_paths()] == before
    assert "2_small_room_random_2" in next(line for line in again.out.splitlines() if " failed " in line)
    last = cli("resume", "sweep", "--failed")
    assert last.code == 0, last.error
    assert RunFolder(failing).state == "done" and len(RunFolder(failing).episode_paths()) == 2
    assert "has failed" not in last.out and "No run in sweep has failed." in cli("resume", "sweep", "--failed").out
    assert "| 2_small_room_random_2 |" in (tmp_path / "sweep" / "table.md").read_text()


def test_episodes_are_not_overwritten(cli: Cli, tmp_path: Path) -> None:
    """Without its config.yaml a folder is no run, but what it holds took time."""
    assert cli("explore", "-m", *SWEEP, "seed=0,1").code == 0
    run = tmp_path / "sweep" / "1_small_room_random_1"
    (run / "config.yaml").unlink()
    before = {path: path.read_bytes() for path in run.rglob("*") if path.suffix in (".npz", ".jsonl")}
    for words in (("explore", *SWEEP[:-1], f"hydra.run.dir={run}"), ("resume", "sweep", "loop.episodes=3")):
        answer = cli(*words)
        assert answer.code and "of a run, but no config.yaml. Restore that from a copy" in answer.error
        assert {path: path.read_bytes() for path in before} == before
    assert len(RunFolder(tmp_path / "sweep" / "0_small_room_random_0").episode_paths()) == 3


def test_a_run_without_its_plan_is_refused_and_stays_what_it_was(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *SWEEP[:-1], "hydra.run.dir=run").code == 0
    (tmp_path / "run" / "plan.npz").unlink()
    answer = cli("resume", "run", "loop.episodes=3")
    assert answer.code == 2 and "plan.npz" in answer.error and "Restore it from a copy" in answer.error
    assert RunFolder(tmp_path / "run").state == "done"


def test_what_vanishes_while_it_is_measured_is_left_out(cli: Cli, outputs: Path, monkeypatch: pytest.MonkeyPatch
                                                        ) -> None:
    plain = Path.lstat

    def lstat(path: Path) -> os.stat_result:
        if path.name == "status.json":
            raise FileNotFoundError(path)
        return plain(path)
    monkeypatch.setattr(Path, "lstat", lstat)
    assert cli("runs").code == 0


def test_a_run_that_was_killed_before_it_had_begun(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(*_: object) -> None:
        raise KeyboardInterrupt
    with monkeypatch.context() as patched:
        patched.setattr(RunFolder, "create", stop)
        assert cli("explore", *SWEEP[:-1], "seed=4", "hydra.run.dir=run").code == 130
    assert not (tmp_path / "run" / "config.yaml").exists()
    assert cli("resume", "run").code == 0
    assert RunFolder(tmp_path / "run").state == "done" and RunFolder(tmp_path / "run").settings["seed"] == 4
