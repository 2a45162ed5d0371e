"""Runs and sweeps through Hydra's launchers: folders, exit codes, failures that do not end a sweep."""

from __future__ import annotations

import logging
import os
from functools import partial
from itertools import chain, repeat
from pathlib import Path

import pytest
import standin

from curionav_cli.agents.lbs_dreamer.settings import Curiosity
from curionav_cli.config import compose
from curionav_cli.config.compose import Plan, plan
from curionav_cli.config.job import Outcome
from curionav_cli.config.schema import Config
from curionav_cli.config.sources import opened
from curionav_cli.errors import ConfigError, RunFailed
from curionav_cli.execution import sweep_failures
from curionav_cli.execution.launch import INTERRUPTED, Request, launch
from curionav_cli.storage.run_folder import RunFolder

ROOT = Path(__file__).parents[2]

Captured = pytest.CaptureFixture[str]


class Recorded:
    """A summary that remembers."""

    def __init__(self) -> None:
        self.calls: list[tuple[Path, list[Outcome]]] = []

    def __call__(self, folder: Path, outcomes: list[Outcome]) -> None:
        self.calls.append((folder, outcomes))


@pytest.fixture
def recorded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Recorded:
    monkeypatch.chdir(tmp_path)
    return Recorded()


def go(recorded: Recorded, *words: str, multirun: bool = False) -> int:
    return launch(Request("explore", ["agent=random", *words], multirun), standin.work, recorded)


def test_a_run_has_a_folder_that_says_what_it_is(recorded: Recorded) -> None:
    assert go(recorded, "seed=3") == 0
    (folder, outcomes), = recorded.calls
    assert folder.name.endswith("_small_room_random_3") and folder.parent.parent == Path("outputs")
    assert outcomes == [Outcome(folder.resolve(), result={"seed": 3})]
    assert (folder / "ran").is_file() and (folder / "explore.log").is_file()
    assert (folder / ".hydra" / "overrides.yaml").read_text() == "- agent=random\n- seed=3\n"


def test_runs_in_one_second_do_not_share_a_folder(recorded: Recorded) -> None:
    for _ in range(3):
        assert go(recorded) == 0
    assert len({folder for folder, _ in recorded.calls}) == 3


@pytest.mark.parametrize("name", ["mine", "a/b", "with space, and comma", "{braces}"])
def test_the_folder_may_be_named(recorded: Recorded, tmp_path: Path, name: str) -> None:
    assert go(recorded, f"hydra.run.dir='{name}'") == 0
    assert (tmp_path / name / "ran").is_file()
    assert go(recorded, "seed=1,2", f"hydra.sweep.dir='{name} sweep'", multirun=True) == 0
    assert len(list((tmp_path / f"{name} sweep").glob("*/ran"))) == 2


@pytest.mark.parametrize("launcher", ["local", "cores"])
def test_a_sweep(recorded: Recorded, launcher: str) -> None:
    assert go(recorded, "agent=random,bounce", "seed=1,2", f"launcher={launcher}", multirun=True) == 0
    (folder, outcomes), = recorded.calls
    assert folder.name.endswith("_sweep")
    lines = [path.read_text().split() for path in sorted(folder.glob("*/ran"))]
    assert [" ".join(line[:2]) for line in lines] == ["random 1", "random 2", "bounce 1", "bounce 2"]
    assert [outcome.folder.name for outcome in outcomes] == [
        "0_small_room_random_1", "1_small_room_random_2", "2_small_room_bounce_1", "3_small_room_bounce_2"]
    here = {line[2] for line in lines} == {str(os.getpid())}
    assert here == (launcher == "local")
    assert [path.read_text() for path in folder.glob("*/threads")] == ["1 PASSIVE"] * 4


@pytest.mark.parametrize("launcher", ["local", "cores"])
def test_a_failure_does_not_end_the_sweep(recorded: Recorded, capsys: Captured, launcher: str) -> None:
    assert go(recorded, "seed=13,1,14", f"launcher={launcher}", multirun=True) == 1
    (folder, outcomes), = recorded.calls
    assert [outcome.code for outcome in outcomes] == [1, 0, 1]
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "0_small_room_random_13: ZeroDivisionError: unlucky"
    assert lines[2] == "2_small_room_random_14: the disk is full"
    log = folder / "0_small_room_random_13" / "explore.log"
    assert str(log) in lines[1] and "Traceback" in log.read_text()


def test_a_killed_worker_is_reported_as_such(
        recorded: Recorded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its run notes why; what was asked of the queue meanwhile is not lost."""
    for kills, said in ((3, "(SIGKILL), and not by Linux for lack of memory"), (4, "out of memory: Linux killed")):
        counted = chain([3], repeat(kills))
        monkeypatch.setattr(sweep_failures, "memory_kills", partial(next, counted))
        with pytest.raises(RunFailed) as failed:
            go(recorded, "seed=17", "launcher=cores", f"hydra.sweep.dir=sweep{kills}", multirun=True)
        assert said in str(failed.value) and f"sweep{kills}" in str(failed.value).partition("curionav resume ")[2]
        status = RunFolder(tmp_path / f"sweep{kills}" / "0_small_room_random_17").status
        assert status["state"] == "interrupted" and said in status["error"]


def test_linux_counts_its_kills() -> None:
    assert sweep_failures.memory_kills() >= 0
    assert Path("/proc/vmstat").exists() == any(
        line.startswith("oom_kill ") for line in Path("/proc/vmstat").read_text().splitlines())


def test_a_failure_without_a_status_gets_one(recorded: Recorded) -> None:
    assert go(recorded, "seed=13,1", multirun=True) == 1
    (folder, _), = recorded.calls
    status = RunFolder(folder / "0_small_room_random_13").status
    assert status == {"state": "failed", "error": "ZeroDivisionError: unlucky"}


def test_what_failed_before_is_spared(recorded: Recorded, capsys: Captured) -> None:
    words = ["agent=random", "seed=13,1", "hydra.sweep.dir=sweep"]
    assert go(recorded, *words[1:], multirun=True) == 1
    Path("sweep/0_small_room_random_13/explore.log").unlink()
    capsys.readouterr()
    assert launch(Request("explore", words, True, skip_failed=True), standin.work, recorded) == 1
    assert "failed before. To run it again: curionav resume" in capsys.readouterr().err
    assert RunFolder(Path("sweep/0_small_room_random_13")).status["error"] == "ZeroDivisionError: unlucky"


def test_ctrl_c_names_the_jobs_of_a_queue(tmp_path: Path) -> None:
    def to_go_on(folder: Path) -> str:
        return sweep_failures.how_to_continue(Plan([], True, folder, [[]], beside=True, queued=True))
    assert to_go_on(tmp_path / "a b") == f"To go on: curionav resume '{tmp_path}/a b'"
    for name in ("7", "12", "%j"):
        (tmp_path / ".submitit" / name).mkdir(parents=True)
    assert "To stop them: scancel 7 12\n" in to_go_on(tmp_path)


FAILURES = [
    (13, 1, "ZeroDivisionError: unlucky"),
    (14, 1, "the disk is full"),
    (15, 2, "that folder holds another run"),
]


@pytest.mark.parametrize(("seed", "code", "line"), FAILURES)
def test_how_a_run_fails(recorded: Recorded, capsys: Captured, seed: int, code: int, line: str) -> None:
    assert go(recorded, f"seed={seed}") == code
    assert capsys.readouterr().err.splitlines()[0] == line
    assert "Traceback" in (recorded.calls[0][0] / "explore.log").read_text()


@pytest.mark.parametrize("words", [["seed=16"], ["-m", "seed=1,16,2"]])
def test_ctrl_c(recorded: Recorded, capsys: Captured, words: list[str]) -> None:
    assert go(recorded, *[word for word in words if word != "-m"], multirun="-m" in words) == INTERRUPTED
    said = capsys.readouterr()
    assert "curionav resume outputs" in said.err
    assert ("not started: 2: seed=2\n" in said.out) == ("-m" in words)
    assert len(recorded.calls) == 1, "the summary comes after an interruption too"


def test_a_folder_that_cannot_be_made(recorded: Recorded, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigError, match="file is a file"):
        go(recorded, "hydra.run.dir=file/run")


def test_a_check_refuses_every_job_beforehand(recorded: Recorded, tmp_path: Path) -> None:
    def check(settings: Config) -> None:
        if settings.seed == 2:
            raise ConfigError("not this one")
    with pytest.raises(ConfigError, match="not this one"):
        launch(Request("explore", ["seed=1,2"], multirun=True), standin.work, recorded, check)
    assert not list(tmp_path.iterdir()) and not recorded.calls


def test_an_experiment_may_hold_its_own_sweep(recorded: Recorded, tmp_path: Path) -> None:
    (tmp_path / "own" / "experiment").mkdir(parents=True)
    (tmp_path / "own" / "experiment" / "two.yaml").write_text(
        "# @package _global_\nhydra:\n  mode: MULTIRUN\n  sweeper:\n    params:\n      seed: 1,2\n")
    request = Request("explore", ["agent=random", "experiment=two"], config_dirs=(Path("own"),))
    assert launch(request, standin.work, recorded) == 0
    assert [outcome.result["seed"] for outcome in recorded.calls[0][1]] == [1, 2]


def test_a_users_directory_reaches_the_workers(recorded: Recorded, tmp_path: Path) -> None:
    (tmp_path / "own" / "agent").mkdir(parents=True)
    (tmp_path / "own" / "agent" / "stubborn.yaml").write_text("defaults:\n  - sticky\n\nname: sticky\n")
    words = ["agent=stubborn", "seed=1,2", "launcher=cores"]
    request = Request("explore", words, multirun=True, config_dirs=(Path("own"),))
    assert launch(request, standin.work, recorded) == 0
    assert all("sticky" in outcome.folder.name for outcome in recorded.calls[0][1])


def test_logging_is_left_as_it_was(recorded: Recorded) -> None:
    before = list(logging.getLogger().handlers), logging.getLogger().level
    assert go(recorded) == 0
    assert (logging.getLogger().handlers, logging.getLogger().level) == before


def test_the_declared_experiment_has_every_curiosity_on_five_seeds(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compose, "COMPOSED", 1)  # each value once
    others = next(line for line in (ROOT / "Makefile").read_text().splitlines() if "agent.curiosity=" in line)
    named = next(word for word in others.split() if word.startswith("agent.curiosity="))
    with opened("explore") as hydra:
        jobs = [job for words in ([], [named])
                for job in plan(hydra, ["experiment=curiosity_controls", *words], multirun=bool(words)).jobs]
    arms = {(word.partition("=")[2], other) for job in jobs for word in job for other in job
            if word.startswith("agent.curiosity=") and other.startswith("seed=")}
    declared = set(Curiosity) - {Curiosity.lbs_count}  # which was not there when it was declared
    assert arms == {(choice.value, f"seed={seed}") for choice in declared for seed in range(5)}
    assert len(jobs) == len(arms)
