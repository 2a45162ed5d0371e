"""What curionav watch reads of a run that goes on: only what is new, and nothing is written."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from curionav_cli.errors import RunFolderError
from curionav_cli.execution.watching import watched_run
from curionav_cli.execution.watching.watched import Watched
from curionav_cli.records import Prediction, Surprise
from curionav_cli.results.coverage import cover
from curionav_cli.results.watching import rows as rows_module
from curionav_cli.results.watching.rows import POINTS, Rows
from curionav_cli.storage.run_folder import RunFolder


def seen(watched: Watched, metric: str = "") -> dict:
    return json.loads(watched.state(metric))


def begun(path: Path, a_plan, episodes: int = 0, an_episode=None, **status) -> RunFolder:
    """A run folder with some episodes, as a run that goes on leaves it."""
    run = RunFolder(path)
    run.create("{env: {name: small_room, map: null}, agent: {name: random}, robot: {}, seed: 3}", {}, {}, a_plan())
    for index in range(episodes):
        more(run, index, an_episode)
    run.set_status(**{"state": "running", "episode": episodes, "episodes": 10, "coverage": 0.1 * episodes, **status})
    return run


def more(run: RunFolder, index: int, an_episode) -> None:
    run.save_episode(index, an_episode(steps=20))
    run.append_metrics({"episode": index, "steps": 20 * (index + 1), "coverage": 0.1 * (index + 1), "docked": True,
                        "loss": float("nan"), "found": [1], "seconds_acting": 2.0, "seconds_learning": 1.0})


def fingerprint(folder: Path) -> dict[str, tuple[int, str]]:
    """When each file and folder was last written, and a checksum of each file."""
    found = [folder, *folder.rglob("*")]
    return {str(path): (path.stat().st_mtime_ns,
                        hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "") for path in found}


def test_a_sweep_with_runs_in_every_state(tmp_path: Path, a_plan, an_episode) -> None:
    sweep = tmp_path / "sweep"
    for number, (state, error) in enumerate((("done", None), ("failed", "no memory"), ("running", None))):
        begun(sweep / f"{number}_a", a_plan, 2, an_episode, state=state, error=error)
    (sweep / "3_a" / ".hydra").mkdir(parents=True)
    (sweep / "4_a").mkdir()
    (sweep / "4_a" / "status.json").write_text('{"state": "runn')
    (sweep / "figures").mkdir()
    (sweep / "multirun.yaml").write_text(
        "{hydra: {job: {name: explore}, overrides: {task: ['seed=range(3)', 'agent=random,bounce', env=small_room]},"
        " sweeper: {params: null}}}")
    before = fingerprint(sweep)
    watched = Watched(sweep)
    state = seen(watched)
    assert [run["state"] for run in state["runs"]] == ["done", "failed", "interrupted", "waiting", "broken"]
    assert state["summary"].startswith("6 runs: 2 waiting") and "1 failed" in state["summary"]
    assert state["runs"][1]["error"] == "no memory" and state["runs"][0]["label"] == "small_room, random, seed 3"
    assert state["metrics"] == ["coverage", "seconds_acting", "seconds_learning"] and state["metric"] == "coverage"
    assert state["runs"][0]["points"] == [[20, 0.1], [40, 0.2]] and state["runs"][3]["points"] == []
    assert seen(watched, "seconds_acting")["runs"][0]["points"] == [[20, 2.0], [40, 2.0]]
    assert all(watched.picture(kind, "0_a") for kind in ("heatmap", "camera"))
    assert watched.picture("heatmap", "3_a") is None and watched.picture("heatmap", "../sweep/0_a") is None
    assert fingerprint(sweep) == before


def test_time_left_at_the_pace_of_the_last_rows(tmp_path: Path, a_plan, an_episode) -> None:
    run = begun(tmp_path / "run", a_plan, 4, an_episode)
    with run.locked():
        (row,) = seen(Watched(run.path))["runs"]
    assert row["state"] == "running" and row["progress"] == "4/10"
    assert row["seconds_left"] == pytest.approx(6 * 3.0) and row["left"] == "0 min 18 s"


def test_runs_that_begin_later_and_grow_are_seen(tmp_path: Path, a_plan, an_episode) -> None:
    sweep = tmp_path / "sweep"
    run = begun(sweep / "0_a", a_plan, 1, an_episode)
    watched = Watched(sweep)
    assert [one["name"] for one in seen(watched)["runs"]] == ["0_a"]
    first = watched.picture("heatmap", "0_a")
    more(run, 1, an_episode)
    run.set_status(episode=2)
    begun(sweep / "1_a", a_plan)
    state = seen(watched)
    assert [one["name"] for one in state["runs"]] == ["0_a", "1_a"] and len(state["runs"][0]["points"]) == 2
    assert watched.picture("heatmap", "0_a") != first
    assert (watched.runs["0_a"].coverage().visits == cover(run.plan, run.poses()).visits).all()


def test_what_did_not_change_is_not_read_again(tmp_path: Path, a_plan, an_episode, monkeypatch) -> None:
    sweep = tmp_path / "sweep"
    for number in range(40):
        begun(sweep / f"{number}_a", a_plan, 2, an_episode, state="done")
    watched, opened = Watched(sweep), []
    seen(watched)
    watched.picture("heatmap", "0_a")
    for module in (rows_module, watched_run):
        monkeypatch.setattr(module, "open", lambda *words: opened.append(words), raising=False)
    monkeypatch.setattr(RunFolder, "status", property(lambda run: opened.append(run.path)))
    monkeypatch.setattr(watched_run, "read_arrays", lambda *words: opened.append(words))
    seen(watched)
    assert watched.picture("heatmap", "0_a") and opened == []


def test_a_rewound_run_is_counted_anew(tmp_path: Path, a_plan, an_episode) -> None:
    run = begun(tmp_path / "run", a_plan, 3, an_episode)
    watched = Watched(run.path)
    watched.picture("heatmap", "run")
    run.rewind(1)
    run.set_status(episode=1)
    assert len(seen(watched)["runs"][0]["points"]) == 1
    assert (watched.runs["run"].coverage().visits == cover(run.plan, run.poses()).visits).all()


def test_the_camera_beside_what_was_predicted(tmp_path: Path, a_plan, an_episode) -> None:
    run = begun(tmp_path / "run", a_plan, 1, an_episode)
    image = np.full((1, 2, 64, 64, 3), (250, 100, 0), np.uint8)
    errors = np.zeros((1, 5), np.float32)
    nothing = Surprise(np.zeros((1, 1), np.int64), np.zeros((1, 1), np.float32), np.zeros((1, 1), np.float32))
    run.save_prediction(0, Prediction(np.array([0, 5]), np.array([[3, 8]]), image, errors, errors, nothing))
    watched = Watched(run.path)
    shown = {kind: cv2.imdecode(np.frombuffer(watched.picture(kind, "run"), np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
             for kind in ("camera", "observed", "predicted")}
    stored = an_episode(steps=20).image
    assert (shown["predicted"] == image[0, 1]).all()
    assert (shown["camera"] == stored[-1]).all() and (shown["observed"] == stored[8]).all()


def test_rows_are_read_as_they_are_appended(tmp_path: Path) -> None:
    path = tmp_path / "metrics.jsonl"
    rows = Rows(path)
    rows.update()
    path.write_text('{"steps": 1, "loss": 2.5}\n{"steps": 2, "lo')
    rows.update()
    assert rows.points("loss") == [(1, 2.5)]
    with open(path, "a") as file:
        file.write('ss": 1.5}\nbroken\n[1]\n')
    rows.update()
    assert rows.points("loss") == [(1, 2.5), (2, 1.5)]
    path.with_name("new").write_text("".join(json.dumps({"iterations": n, "loss": n}) + "\n" for n in range(1000)))
    path.with_name("new").replace(path)
    rows.update()
    thin = rows.points("loss")
    assert len(thin) <= POINTS and thin[-1] == (999, 999) and rows.points("nothing") == []


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RunFolderError, match="holds no run"):
        Watched(tmp_path)
