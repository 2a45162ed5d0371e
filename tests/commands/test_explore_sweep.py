"""A sweep through the entry point: its table, jobs that fail, and what resume does after an interruption."""

from __future__ import annotations

from pathlib import Path

import pytest
from entry import Cli

from curionav_cli import build
from curionav_cli.agents.agent import Agent
from curionav_cli.config.schema import Config
from curionav_cli.errors import ConfigError
from curionav_cli.execution.recorder import Recorder
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scene.scene import Scene

unseen = pytest.mark.usefixtures("blank_figures")
SHORT = ("env=small_room", "loop.steps=30", "loop.episodes=3")


@pytest.mark.usefixtures("painted")
def test_a_sweep_ends_with_one_table_over_all_runs(cli: Cli, tmp_path: Path) -> None:
    answer = cli("explore", "-m", *SHORT, "agent=random,bounce", "seed=0,1", "hydra.sweep.dir=sweep")
    assert answer.code == 0, answer.error
    table = (tmp_path / "sweep" / "table.md").read_text()
    assert sum(line.startswith("| small_room") for line in table.splitlines()) == 4
    for name in ("coverage_small_room.png", "heatmaps_small_room.png"):
        assert (tmp_path / "sweep" / "figures" / name).stat().st_size > 5000
    assert len((tmp_path / "sweep" / "results.csv").read_text().splitlines()) == 5


@unseen
def test_a_failed_job_does_not_end_the_sweep_and_is_reported(
        cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = Recorder.episode_done

    def fails(recorder: Recorder, *words: object) -> None:
        if type(recorder.agent).__name__ == "Sticky":
            raise FloatingPointError("a loss is not finite")
        plain(recorder, *words)
    monkeypatch.setattr(Recorder, "episode_done", fails)
    answer = cli("explore", "-m", *SHORT, "agent=sticky,random", "hydra.sweep.dir=sweep")
    assert answer.code == 1 and "a loss is not finite" in answer.error and "Traceback" not in answer.error
    states = {path.parent.name: RunFolder(path.parent).state for path in (tmp_path / "sweep").glob("*/status.json")}
    assert sorted(states.values()) == ["done", "failed"]
    assert "failed" in (tmp_path / "sweep" / "table.md").read_text()


@unseen
def test_an_interrupted_sweep_is_resumed_to_its_end(
        cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(recorder: Recorder, step: int) -> None:
        if type(recorder.agent).__name__ == "Bounce":
            raise KeyboardInterrupt
    with monkeypatch.context() as patched:
        patched.setattr(Recorder, "acted", stop)
        answer = cli("explore", "-m", *SHORT, "agent=random,bounce,sticky", "hydra.sweep.dir=a sweep")
    assert answer.code == 130 and "curionav resume" in answer.error
    assert len(list((tmp_path / "a sweep").glob("*/metrics.jsonl"))) < 3
    again = cli("resume", "a sweep")
    assert again.code == 0, again.error
    runs = sorted((tmp_path / "a sweep").glob("*/run.json"))
    names = [f"small_room_{name}_0" for name in ("random", "bounce", "sticky")]
    assert [path.parent.name[2:] for path in runs] == names
    assert all(RunFolder(path.parent).state == "done" for path in runs)


@unseen
def test_a_broken_run_does_not_keep_the_others_from_going_on(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", "-m", *SHORT, "agent=random,bounce", "hydra.sweep.dir=sweep").code == 0
    broken, sound = sorted((tmp_path / "sweep").glob("*_0"))
    (broken / "episodes" / "000001.npz").unlink()
    answer = cli("resume", "sweep", "loop.episodes=4")
    assert answer.code == 1 and "000001.npz is missing" in answer.error and "Traceback" not in answer.error
    assert len(RunFolder(sound).metrics()) == 4


@unseen
def test_jobs_that_leave_no_folder_are_in_the_table(
        cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plain = build.agent

    def fails(settings: Config, world: Scene) -> Agent:
        if settings.agent.name == "sticky":
            raise ConfigError("there is no device for it")
        return plain(settings, world)
    monkeypatch.setattr(build, "agent", fails)
    answer = cli("explore", "-m", *SHORT, "agent=sticky,random", "hydra.sweep.dir=sweep")
    assert answer.code == 1 and "there is no device for it" in answer.error and "Traceback" not in answer.error
    rows = (tmp_path / "sweep" / "results.csv").read_text().splitlines()
    assert len(rows) == 3 and any("failed" in row for row in rows) and any(",done," in row for row in rows)
