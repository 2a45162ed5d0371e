"""Sweepers that draw their own values: what they receive, what is refused beforehand, and searches that go on."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import standin
import yaml
from entry import Cli
from tiny import LEARNER

from curionav_cli.commands.summary import best_first
from curionav_cli.config import catalogue
from curionav_cli.config.compose import Plan, plan
from curionav_cli.config.job import Outcome, Trial
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.schema import Config
from curionav_cli.config.search import Engine
from curionav_cli.config.sources import opened
from curionav_cli.errors import ConfigError, RunFailed
from curionav_cli.execution import sweep_failures
from curionav_cli.execution.launch import INTERRUPTED, Request, launch
from curionav_cli.storage.run_folder import RunFolder

optuna = pytest.importorskip("optuna", reason="needs the extra hpo")

SEARCH = ("hydra/sweeper=optuna", "hydra.sweep.dir=sweep")
DRAWN = (*SEARCH, "hydra/sweeper/sampler=random", "hydra.sweeper.sampler.seed=1", "hydra.sweeper.n_trials=6")
Captured = pytest.CaptureFixture[str]


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def go(*words: str, work: Callable[[Config, Path], dict[str, Any]] = standin.work) -> int:
    return launch(Request("explore", ["agent=random", *words], True), work, lambda *_: None, objective="coverage")


def trials() -> list[Any]:
    return optuna.load_study(study_name="search", storage="sqlite:///sweep/search.sqlite").trials


def states() -> str:
    return " ".join(trial.state.name for trial in trials())


def covered(settings: Config, folder: Path) -> dict[str, Any]:
    """A run that covers the more the greater its seed; Ctrl-C ends seed 16 the first time."""
    if settings.seed == 16 and not (folder / "begun").exists():
        (folder / "begun").touch()
        raise KeyboardInterrupt
    (folder / "ran").write_text(str(settings.seed))
    return {"coverage": settings.seed / 100}


def ran() -> list[str]:
    return sorted(path.parent.name.split("_")[0] + ":" + path.read_text() for path in Path("sweep").glob("*/ran"))


def test_a_failed_trial_ends_nothing_and_its_reason_stands_in_its_folder(capsys: Captured) -> None:
    assert go("seed=13,1", *DRAWN) == 1
    assert len(trials()) == 6 and set(states().split()) == {"COMPLETE", "FAIL"}
    said = capsys.readouterr()
    assert said.out.startswith("optuna searches for the largest coverage (hydra.sweeper.direction=maximize), 6 "
                               "trials:\n  seed=13,1\n")
    assert "Failed experiment: " in said.out and "Best parameters: {'seed': 1}" in said.out
    for unlucky in Path("sweep").glob("*_13"):
        assert f"{unlucky.name}: ZeroDivisionError: unlucky\n" in said.err
        assert RunFolder(unlucky).status == {"state": "failed", "error": "ZeroDivisionError: unlucky"}
        assert "Traceback" in (unlucky / "explore.log").read_text()


def test_a_search_ends_where_more_fail_than_may(capsys: Captured) -> None:
    with pytest.raises(RunFailed, match=r"could not be run: .*To go on: curionav resume sweep"):
        go("seed=13,14", *DRAWN, "hydra.sweeper.max_failure_rate=0.5")
    assert states() == "FAIL FAIL" and "0_small_room_random_1" in capsys.readouterr().err


def test_an_engine_that_only_minimises_gets_the_negative() -> None:
    engine = Engine("hydra_orion_sweeper", True, ["x=1"])
    assert engine.about("coverage").startswith("orion searches for the largest coverage (it minimises the negative):")
    other = Engine("hydra_other_sweeper", True, ["x=1"])
    assert other.about("coverage").startswith("other searches for coverage (the direction is its own):")

    class Fixed(Trial):
        def outcome(self, config: Any) -> Outcome:
            return Outcome(Path("run"), result={"coverage": 0.25})
    assert Fixed(standin.work, -1)(None) == -0.25 and Fixed(standin.work)(None) == 0.25  # type: ignore[arg-type]


def test_what_was_cut_off_is_taken_up_first_with_its_number(capsys: Captured) -> None:
    assert go("seed=16,1", *DRAWN, work=covered) == INTERRUPTED
    assert "To go on: curionav resume sweep\n" in capsys.readouterr().err
    begun = [(trial.number, trial.params["seed"]) for trial in trials()]
    assert "RUNNING" in states()
    with pytest.raises(ConfigError, match=r"holds a search in another direction"):
        go("seed=16,1", *DRAWN, "hydra.sweeper.direction=minimize", work=covered)
    while go("seed=16,1", *DRAWN, work=covered) == INTERRUPTED:
        pass
    ended = [(trial.number, trial.params["seed"]) for trial in trials()]
    assert ended[:len(begun)] == begun and states() == " ".join(["COMPLETE"] * 6)
    assert ran() == [f"{number}:{seed}" for number, seed in ended]
    assert yaml.safe_load(Path("sweep/optimization_results.yaml").read_text())["best_params"] == {"seed": 16}


def test_a_seeded_sampler_does_not_draw_again_what_it_drew() -> None:
    for number in (2, 4):
        assert go("seed=int(interval(0,1000000))", *DRAWN[:-1], f"hydra.sweeper.n_trials={number}", work=covered) == 0
    assert len({trial.params["seed"] for trial in trials()}) == 4


def test_a_search_without_a_file_says_that_it_cannot_go_on(capsys: Captured) -> None:
    assert go("seed=16,16", *DRAWN, "hydra.sweeper.storage=null", work=covered) == INTERRUPTED
    said = capsys.readouterr()
    assert "This sweeper cannot be resumed; its runs can" in said.err and "To go on" not in said.err
    assert not Path("sweep/multirun.yaml").exists()


REFUSED = {
    "seed=0,1 hydra.sweeper.direction=maximise": "'maximise' is not one of maximize, minimize. Did you mean maximize?",
    "seed=0,1 hydra.sweeper.direction=[maximize,minimize]": "a run has one objective. Give one direction",
    "seed=0,1 hydra.sweeper.n_trial=3": "no key hydra.sweeper.n_trial. Did you mean hydra.sweeper.n_trials",
    "seed=0,1 hydra.sweeper.n_trials=0": "hydra.sweeper.n_trials=0 is less than 1.",
    "seed=0,1 hydra.sweeper.n_jobs=-1": "hydra.sweeper.n_jobs=-1 is less than 1.",
    "seed=0,1 hydra.sweeper.max_failure_rate=2": "hydra.sweeper.max_failure_rate=2.0 is more than 1.",
    "seed=0,1 hydra.sweeper.custom_search_space=os.mkdir": "custom_search_space would be called",
    "seed=0,1 hydra.sweeper.storage=sqlite:///elsewhere": "storage: a search is kept in the sweep's folder",
    "seed=0,1 hydra.sweeper.storage=sqlite:///${hydra.sweep.dir}/../x": "storage: a search is kept in the sweep's",
    "seed=3": "Nothing is searched.",
    "seed=interval(0,3)": "draws fractions, and seed is a whole number. Draw whole ones: 'seed=int(interval(0,3))'",
    "agent=sticky agent.repeat=interval(0,2)": "agent.repeat: 2.0 is not between 0 and 1",
    "agent=sticky agent.repeat=interval(-1,1)": "agent.repeat: -1.0 is not between 0 and 1",
    "loop.steps=range(0,9)": "loop.steps: 0 is not between 1 and",
    "agent=bounce agent.min_turn=interval(1,12)": "agent.min_turn: 1.0 is not between 10 and 180",
    "agent=bounce agent.min_turn=interval(10,170) agent.max_turn=120,160": "max_turn: 120.0 is not between 170.0",
    "seed=0,1 hydra/sweeper/sampler=grid": "a grid is what a plain sweep runs, and that can be resumed.",
    "agent=random,sticky device=cpu,gpu": "device: 'gpu' is not one of",
    'agent.repeat="uniform(0,1)" agent=sticky seed=1,2': "agent.repeat: '\"uniform(0,1)\"' is not a number",
}


@pytest.mark.parametrize("typed", REFUSED)
def test_refused_before_anything_runs(tmp_path: Path, typed: str) -> None:
    words = ["agent=random", *typed.split(), *SEARCH]
    words = list({word.partition("=")[0]: word for word in words}.values())
    with opened("explore") as hydra, pytest.raises(ConfigError) as refused:
        plan(hydra, words, True, lambda settings: None)
    assert REFUSED[typed] in str(refused.value)
    assert not list(tmp_path.iterdir())


def test_optuna_draws_the_end_of_a_range_too() -> None:
    with opened("explore") as hydra:
        jobs = plan(hydra, ["agent=random", "seed=range(0,7,3)", *SEARCH], True).jobs
    assert [word for job in jobs for word in job if word.startswith("seed=")] == ["seed=0", "seed=6"]


def test_distributions_in_the_words_of_another_sweeper_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    from curionav_cli.config import search
    monkeypatch.setattr(search, "OPTUNA", "another")
    words = ["agent=bounce", 'agent.max_turn="uniform(130,170)"', "seed=1", *SEARCH]
    with opened("explore") as hydra:
        todo = plan(hydra, words, True, lambda settings: None)
    assert todo.engine and todo.engine.space == ['agent.max_turn="uniform(130,170)"'] and not todo.engine.resumable
    assert not any("uniform" in word for job in todo.jobs for word in job)


def test_a_sweeper_needs_a_sweep_and_its_extra(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    answer = cli("explore", "agent=random", "hydra/sweeper=optuna")
    assert answer.code == 2 and "hydra/sweeper=optuna is for sweeps. Add -m: curionav explore -m" in answer.error
    monkeypatch.setattr(catalogue, "options_of", lambda hydra, group: ["basic"] if group == "hydra/sweeper" else [])
    with opened("explore") as hydra, pytest.raises(ConfigError, match=r"hydra/sweeper=optuna needs the extra hpo"):
        OverrideErrors(hydra, ["hydra/sweeper=optuna"]).parse(True)


def test_only_what_has_an_objective_is_searched(cli: Cli) -> None:
    answer = cli("sheet", "-m", "env.camera=0.3,0.4", "agent=random", "hydra/sweeper=optuna")
    assert answer.code == 2 and "curionav sheet has no objective to search by." in answer.error
    assert len(answer.error.splitlines()) == 1


def test_a_search_by_the_command_and_its_resume(cli: Cli) -> None:
    words = ("agent=random", "loop.episodes=1", "loop.steps=9", "hydra.sweeper.n_trials=1", *SEARCH)
    answer = cli("explore", "-m", "seed=int(interval(0,99))", *words)
    assert answer.code == 0, answer.error
    assert "sweep/optimization_results.yaml" in answer.out and "Best parameters: " in answer.out
    assert "resume sweep hydra.sweeper.n_trials=2   (the same search, longer)" in answer.out
    assert "loop.episodes" not in answer.out
    for change in ("loop.episodes=3", "agent.repeat=1"):
        assert "What may change: hydra.sweeper.n_trials, loop.keep, init" in cli("resume", "sweep", change).error
    assert "records each trial once" in cli("resume", "sweep", "--failed").error
    answer = cli("resume", "sweep", "hydra.sweeper.n_trials=2")
    assert answer.code == 0 and [trial.number for trial in trials()] == [0, 1]
    assert sorted(path.parent.name[0] for path in Path("sweep").glob("*/run.json")) == ["0", "1"]


def test_the_best_stands_first() -> None:
    rows = [{"coverage": 0.1}, {"coverage": None}, {"coverage": 0.3}]
    assert [row["coverage"] for row in sorted(rows, key=partial(best_first, direction="maximize"))] == [0.3, 0.1, None]
    assert [row["coverage"] for row in sorted(rows, key=partial(best_first, direction="minimize"))] == [0.1, 0.3, None]


def test_scancel_is_for_slurm(tmp_path: Path) -> None:
    (tmp_path / ".submitit" / "7").mkdir(parents=True)
    assert "To stop them" not in sweep_failures.how_to_continue(Plan([], True, tmp_path, [[]], beside=True))
    with opened("explore") as hydra:
        for launcher, queued in (("submitit_local", False), ("submitit_slurm", True)):
            words = ["agent=random", "seed=1,2", f"hydra/launcher={launcher}"]
            assert plan(hydra, words, True).queued == queued


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_twelve_trials_killed_and_resumed(cli: Cli) -> None:
    """Options of scale=cpu, at toy size: SIGKILL in the middle, then resume, as docs/scaling.md says."""
    tiny = [word for word in LEARNER if not word.startswith(("env=", "agent="))]
    line = ["explore", "experiment=search", *tiny, "loop.episodes=2", "hydra.sweep.dir=sweep"]
    with subprocess.Popen([sys.executable, "-m", "curionav_cli", *line]) as process:
        try:
            while process.poll() is None and len(list(Path("sweep").glob("*/checkpoint"))) < 5:
                time.sleep(0.05)
        finally:
            process.send_signal(signal.SIGKILL)
    assert process.returncode == -signal.SIGKILL and "RUNNING" in states()
    before = [(trial.number, trial.params) for trial in trials() if trial.state.name == "COMPLETE"]
    assert cli("resume", "sweep").code == 0
    assert states() == " ".join(["COMPLETE"] * 12)
    assert [(trial.number, trial.params) for trial in trials()][:len(before)] == before
    folders = sorted(int(path.parent.name.split("_")[0]) for path in Path("sweep").glob("*/run.json"))
    assert folders == list(range(12))
    for trial in trials():
        run, = Path("sweep").glob(f"{trial.number}_*/status.json")
        assert RunFolder(run.parent).status["coverage"] == trial.value
