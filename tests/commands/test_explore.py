"""A whole run through the entry point: what it leaves behind, and what it says when it cannot go on."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from entry import Cli

from curionav_cli.execution.recorder import Recorder
from curionav_cli.storage.run_folder import RunFolder

pytestmark = pytest.mark.usefixtures("blank_figures")
SHORT = ("env=small_room", "loop.steps=30", "loop.episodes=3")


def a_map(folder: Path) -> None:
    """A room of 3 x 4 m as a ROS map, room.yaml."""
    cv2.imwrite(str(folder / "room.png"), np.pad(np.full((60, 80), 254, np.uint8), 3))
    (folder / "room.yaml").write_text("image: room.png\nresolution: 0.05\norigin: [0, 0, 0]\n"
                                      "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")


def metrics(run: Path) -> list[dict]:
    return [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]


def status(run: Path) -> dict:
    return RunFolder(run).status


def test_a_run_folder_holds_what_scripts_rely_on(cli: Cli, tmp_path: Path) -> None:
    answer = cli("explore", *SHORT, "agent=bounce", "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    run = tmp_path / "run"
    names = {str(path.relative_to(run)) for path in run.rglob("*")}
    assert names >= {"config.yaml", "run.json", "status.json", "metrics.jsonl", "episodes/000002.npz",
                     "checkpoint/000003/done", "figures/heatmap.png", "figures/coverage.png", "table.md",
                     "results.csv", "plan.npz"}
    with np.load(run / "episodes" / "000001.npz") as episode:
        assert episode["image"].shape == (31, 64, 64, 3) and episode["image"].dtype == np.uint8
        assert episode["action"].shape == (30,) and episode["collided"].shape == (30,)
        assert episode["pose"].shape == (31, 3) and episode["pose"].dtype == np.float64
        assert episode["collided"].dtype == bool
    rows = metrics(run)
    assert [(row["episode"], row["steps"]) for row in rows] == [(0, 30), (1, 60), (2, 90)]
    assert rows[-1].keys() >= {"visited", "visitable", "coverage", "seconds_acting", "seconds_learning"}
    last = status(run)
    assert last["state"] == "done" and last["episode"] == 3 and last["steps"] == 90 and last["error"] is None
    assert last["coverage"] == rows[-1]["coverage"] == last["visited"] / last["visitable"] > 0
    about = json.loads((run / "run.json").read_text())
    assert about["command"].startswith("curionav explore env=small_room") and about["engine"] == "numpy"


def test_off_a_terminal_there_is_one_plain_line_an_episode(cli: Cli) -> None:
    answer = cli("explore", *SHORT, "agent=random", "hydra.run.dir=run")
    lines = [line for line in answer.out.splitlines() if "episode" in line and "steps/s" in line]
    assert len(lines) == 3 and "\x1b" not in answer.out
    assert "episode 2/3, 60 steps" in lines[1] and "coverage" in lines[1] and "left" in lines[1]
    assert "run/figures/heatmap.png" in answer.out and "curionav" in answer.out


@pytest.mark.parametrize("agent", ["random", pytest.param("sticky", marks=pytest.mark.slow), "bounce", "frontier"])
def test_the_same_seed_gives_the_same_run(cli: Cli, tmp_path: Path, agent: str) -> None:
    for name, seed in (("one", 5), ("two", 5), ("other", 6)):
        assert cli("explore", *SHORT, f"agent={agent}", f"seed={seed}", f"hydra.run.dir={name}").code == 0
    one, two, other = ((tmp_path / name / "episodes" / "000002.npz").read_bytes() for name in ("one", "two", "other"))
    assert one == two
    if agent not in ("bounce", "frontier"):  # those two may go the same way by other draws
        assert one != other


def test_ctrl_c_is_noted_and_the_run_goes_on(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(recorder: Recorder, step: int) -> None:
        if recorder.coverage.steps == 30 and step == 10:
            raise KeyboardInterrupt
    with monkeypatch.context() as patched:
        patched.setattr(Recorder, "acted", stop)
        answer = cli("explore", *SHORT, "agent=random", "hydra.run.dir=run")
    assert answer.code == 130 and "Traceback" not in answer.error
    assert "curionav resume run" in answer.error
    assert status(tmp_path / "run")["state"] == "interrupted" and len(metrics(tmp_path / "run")) == 1
    again = cli("resume", "run")
    assert again.code == 0 and status(tmp_path / "run")["state"] == "done" and len(metrics(tmp_path / "run")) == 3


@pytest.mark.parametrize("place", ["save_episode", "append_metrics", "write"])
def test_a_full_disk_loses_nothing_that_was_saved(
        cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    plain = getattr(RunFolder, place)

    def full(run: RunFolder, *words: object) -> None:
        if len(run.episode_paths()) >= 2:
            raise OSError(28, "No space left on device")
        plain(run, *words)
    with monkeypatch.context() as patched:
        patched.setattr(RunFolder, place, full)
        answer = cli("explore", *SHORT, "agent=random", "hydra.run.dir=run")
    assert answer.code == 1 and "Traceback" not in answer.error
    assert "The disk is full" in answer.error and f"curionav resume {tmp_path}/run" in answer.error
    assert cli("explore", *SHORT, "agent=random", "hydra.run.dir=whole").code == 0
    assert cli("resume", "run").code == 0
    for n in range(3):
        paths = [tmp_path / name / "episodes" / f"{n:06d}.npz" for name in ("run", "whole")]
        assert paths[0].read_bytes() == paths[1].read_bytes()


def test_a_folder_goes_on_only_with_the_run_that_is_in_it(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *SHORT, "agent=random", "hydra.run.dir=run").code == 0
    for change, said in (("agent=bounce", 'agent.name was "random", now "bounce"'), ("seed=3", "seed was 0, now 3"),
                         ("env.radius=0.15", "env.radius was 0.18, now 0.15")):
        words = {"agent": "agent=random", change.split("=")[0]: change}
        refused = cli("explore", *SHORT, *words.values(), "loop.episodes=4", "hydra.run.dir=run")
        assert refused.code == 2 and said in refused.error
        assert len(refused.error.strip().splitlines()) == 1
    assert len(metrics(tmp_path / "run")) == 3 and status(tmp_path / "run")["state"] == "done"
    longer = cli("explore", "env=small_room", "loop.steps=30", "agent=random", "loop.episodes=4", "hydra.run.dir=run")
    assert longer.code == 0 and len(metrics(tmp_path / "run")) == 4


def test_a_run_without_a_checkpoint_keeps_its_settings_too(
        cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def stop(recorder: Recorder, step: int) -> None:
        raise KeyboardInterrupt
    with monkeypatch.context() as patched:
        patched.setattr(Recorder, "acted", stop)
        assert cli("explore", *SHORT, "agent=random", "hydra.run.dir=run").code == 130
    assert status(tmp_path / "run") | {"error": None} == {
        "state": "interrupted", "error": None, "episode": 0, "episodes": 3, "steps": 0, "visited": 0,
        "visitable": 449, "coverage": 0.0}
    refused = cli("explore", *SHORT, "agent=random", "seed=3", "hydra.run.dir=run")
    assert refused.code == 2 and "seed was 0, now 3" in refused.error


def test_a_longer_run_that_is_killed_stays_longer(
        cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert cli("explore", *SHORT, "agent=random", "hydra.run.dir=run").code == 0

    def stop(recorder: Recorder, step: int) -> None:
        if recorder.coverage.steps == 120:
            raise KeyboardInterrupt
    with monkeypatch.context() as patched:
        patched.setattr(Recorder, "acted", stop)
        assert cli("resume", "run", "loop.episodes=6").code == 130
    assert cli("resume", "run").code == 0
    assert len(metrics(tmp_path / "run")) == 6 and status(tmp_path / "run")["state"] == "done"


def test_resume_changes_only_the_number_of_episodes(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *SHORT, "agent=random", "hydra.run.dir=run").code == 0
    assert cli("resume", "run", "loop.episodes=5").code == 0
    assert len(metrics(tmp_path / "run")) == 5
    for word, said in (("agent=bounce", "agent may not change: a run keeps the settings that it began with. "),
                       ("loop.episodes=x", "loop.episodes: 'x' is not a whole number"),
                       ("loop.episodes=0", "loop.episodes: 0 is not between 1 and")):
        refused = cli("resume", "run", word)
        assert refused.code == 2 and said in refused.error and len(refused.error.strip().splitlines()) == 1


def test_a_run_on_a_map_is_resumed_from_another_folder(
        cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    a_map(tmp_path)
    words = ("env=map", "env.map=room.yaml", "agent=bounce", "loop.steps=20", "loop.episodes=1")
    done = cli("explore", *words, "hydra.run.dir=run")
    assert done.code == 0, done.error
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert cli("resume", "../run", "loop.episodes=2").code == 0
    cv2.imwrite(str(tmp_path / "room.png"), np.pad(np.full((50, 80), 254, np.uint8), 3))  # another building
    refused = cli("resume", "../run", "loop.episodes=3")
    assert refused.code == 2 and "visitable cells (sha256) was" in refused.error


def test_a_half_written_run_is_named(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *SHORT, "agent=random", "hydra.run.dir=run").code == 0
    (tmp_path / "run" / "episodes" / "000001.npz").unlink()
    refused = cli("resume", "run", "loop.episodes=4")
    assert refused.code == 2 and "000001.npz is missing" in refused.error
    (tmp_path / "run" / "config.yaml").unlink()
    refused = cli("resume", "run")
    assert refused.code == 2 and "holds no run" in refused.error


def test_the_tables_of_a_finished_run_say_so(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *SHORT, "agent=random", "hydra.run.dir=run").code == 0
    assert "| done |" in (tmp_path / "run" / "table.md").read_text()
    assert ",done," in (tmp_path / "run" / "results.csv").read_text()


def test_a_second_process_is_kept_out(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *SHORT, "agent=random", "hydra.run.dir=run").code == 0
    with RunFolder(tmp_path / "run").locked():
        refused = cli("resume", "run", "loop.episodes=4")
    assert refused.code == 2 and "is in use by process " in refused.error


def test_a_changed_overlay_is_refused(cli: Cli, tmp_path: Path) -> None:
    a_map(tmp_path)
    (tmp_path / "over.yaml").write_text("light: {drift: 0.1, period: 10}\n")
    words = ("env=map", "env.map=room.yaml", "env.overlay=over.yaml", "agent=random", "loop.steps=5", "loop.episodes=1")
    done = cli("explore", *words, "hydra.run.dir=run")
    assert done.code == 0, done.error
    (tmp_path / "over.yaml").write_text("light: {drift: 0.4, period: 10}\n")
    refused = cli("resume", "run", "loop.episodes=2")
    assert refused.code == 2 and "overlay (sha256) was" in refused.error


def test_a_map_may_move(cli: Cli, tmp_path: Path) -> None:
    a_map(tmp_path)
    words = ("env=map", "env.map=room.yaml", "agent=random", "loop.steps=5", "loop.episodes=1")
    assert cli("explore", *words, "hydra.run.dir=run").code == 0
    (tmp_path / "maps").mkdir()
    for name in ("room.yaml", "room.png"):
        (tmp_path / name).rename(tmp_path / "maps" / name)
    lost = cli("resume", "run", "loop.episodes=2")
    assert lost.code == 2 and "There is no map" in lost.error
    assert cli("resume", "run", "loop.episodes=2", "env.map=maps/room.yaml").code == 0


@pytest.mark.parametrize(("words", "said"), [
    (("agent.name=foo",), "agent.name: 'foo' is not the name of this agent"),
    (("agent.name=bounce",), "agent.name: 'bounce' is not the name of this agent"),
])
def test_what_is_impossible_is_answered_before_anything_is_written(
        cli: Cli, tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    answer = cli("explore", *SHORT, "agent=random", *words, "hydra.run.dir=run")
    assert answer.code == 2 and said in answer.error and not (tmp_path / "run").exists()
