"""Killed by SIGKILL at any moment, a resumed run ends as one without interruption, byte for byte on CPU."""

import json
import shutil
import signal

import pytest
from deadly import DEADLY
from leftovers import leftovers
from tiny import LEARNER

from curionav_cli.files import read_json
from curionav_cli.options import Options
from curionav_cli.records import Episode
from curionav_cli.storage.run_folder import RunFolder

# Kills its own process at a chosen moment of the third episode, as a power cut would.
KILLED = DEADLY + """
from pathlib import Path
from curionav_cli.execution.recorder import Recorder
from curionav_cli.storage import checkpoint
from curionav_cli.storage.run_folder import RunFolder

third = lambda recorder: recorder.coverage.steps == 24
if moment == "acting": at(Recorder, "acted", lambda recorder, step: third(recorder) and step == 7)
if moment == "predicting": at(RunFolder, "save_prediction", lambda run, index, prediction: index == 2)
if moment == "training": at(Recorder, "learned", lambda recorder, i: third(recorder) and i == 2)
if moment == "saving": at(checkpoint, "flush", lambda path: path.parent.name == "000003.part")
if moment == "between": at(RunFolder, "append_metrics", lambda run, row: row["episode"] == 2)
if moment == "drawing": at(RunFolder, "write", lambda run, name, text: name == "table.md")
app.main()
"""


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory, warm):
    run = tmp_path_factory.mktemp("undisturbed") / "run"
    done = warm("explore", *LEARNER, f"hydra.run.dir={run}")
    assert done.returncode == 0, done.stderr
    return leftovers(run)


def test_predictions_are_among_its_files(undisturbed):
    predictions = [name for name in undisturbed if name.startswith("predictions/")]
    assert predictions == [f"predictions/00000{n}.npz" for n in range(4)]
    assert all({"open_loop_mse_5", "repeat_mse_5"} <= row.keys() for row in undisturbed["metrics"])


@pytest.mark.parametrize("moment", ["acting", "predicting", "training", "saving", "between", "drawing"])
def test_a_killed_run_ends_as_an_undisturbed_one(tmp_path, undisturbed, moment, warm):
    run = tmp_path / "run"
    killed = warm(moment, "explore", *LEARNER, f"hydra.run.dir={run}", program=KILLED)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    assert json.loads((run / "status.json").read_text())["state"] == "running"
    resumed = warm("resume", str(run))
    assert resumed.returncode == 0, resumed.stderr
    finished = 4 if moment == "drawing" else 2
    assert f"goes on after {finished} finished episodes" in resumed.stdout
    ours = leftovers(run)
    assert ours.keys() == undisturbed.keys()
    assert [name for name in ours if ours[name] != undisturbed[name]] == []


def test_the_memory_of_the_replay_changes_no_result_and_may_change(tmp_path, undisturbed, warm):
    run, frame = tmp_path / "run", 64 * 64 * 3
    words = (*LEARNER, "loop.replay_memory=0", f"hydra.run.dir={run}")
    killed = warm("training", "explore", *words, program=KILLED)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    resumed = warm("resume", str(run), f"loop.replay_memory={20 * frame / 1e9}")
    assert resumed.returncode == 0, resumed.stderr
    ours = leftovers(run)
    assert [name for name in ours if ours[name] != undisturbed[name]] == ["replay"]
    used = {"episodes": 4, "steps": 48, "bytes_in_memory": 13 * frame, "bytes_on_disk": 39 * frame}
    assert ours["replay"] == used
    assert undisturbed["replay"] == {**used, "bytes_in_memory": 52 * frame, "bytes_on_disk": 0}


def test_a_finished_run_returns_at_once_and_more_episodes_go_on_from_it(tmp_path, undisturbed, warm):
    run = tmp_path / "run"
    short = [word for word in LEARNER if not word.startswith("loop.episodes")]
    assert warm("explore", *short, "loop.episodes=2", f"hydra.run.dir={run}").returncode == 0
    before = {path: path.stat().st_mtime_ns for path in run.rglob("*") if path.is_file() and ".hydra" not in path.parts}
    again = warm("resume", str(run))
    assert again.returncode == 0 and "2/2" not in again.stdout
    assert {path: path.stat().st_mtime_ns for path in before if path.suffix == ".npz"} == \
        {path: time for path, time in before.items() if path.suffix == ".npz"}
    assert "resumed" not in read_json(run / "run.json")
    longer = warm("resume", str(run), "loop.episodes=4")
    assert longer.returncode == 0, longer.stderr
    ours = leftovers(run)
    assert [name for name in ours if ours[name] != undisturbed[name]] == []
    [resumed] = (about := read_json(run / "run.json"))["resumed"]
    assert resumed["episode"] == 2 and resumed["git_commit"] == about["git_commit"] and "numpy" not in resumed
    peaks = [row["peak_memory"] for row in RunFolder(run).metrics()]
    assert len(peaks) == 4 and all(1e8 < peak < 2e9 for peak in peaks)


@pytest.fixture(scope="module")
def finished(tmp_path_factory, warm):
    run = tmp_path_factory.mktemp("finished") / "run"
    words = ("agent=random", "loop.steps=5", "loop.episodes=2", f"hydra.run.dir={run}")
    assert warm("explore", *words).returncode == 0
    return run


@pytest.mark.parametrize(("harm", "said"), [
    (lambda run: (run / "episodes" / "000000.npz").unlink(), "000000.npz is missing"),
    (lambda run: (run / "episodes" / "000000.npz").write_bytes(b"PK"), "000000.npz is not whole"),
    (lambda run: (run / "config.yaml").write_text(""), "config.yaml does not hold the settings"),
    (lambda run: [path.write_text("{") for path in run.glob("checkpoint/*/rng.json")], "000002/rng.json is not whole"),
    (lambda run: shutil.rmtree(run / "checkpoint"), "checkpoint holds no whole checkpoint"),
])
def test_a_broken_run_is_refused_in_one_line(tmp_path, finished, harm, said, warm):
    run = shutil.copytree(finished, tmp_path / "run")
    harm(run)
    refused = warm("resume", str(run), "loop.episodes=3")
    assert refused.returncode == 2 and said in refused.stderr
    assert len(refused.stderr.strip().splitlines()) == 1, refused.stderr


def test_what_is_not_a_run_is_named(tmp_path, warm):
    nothing = warm("resume", str(tmp_path / "nowhere"))
    assert nothing.returncode == 2 and "There is no folder" in nothing.stderr
    empty = warm("resume", str(tmp_path))
    assert empty.returncode == 2 and "holds no run" in empty.stderr


def test_a_run_of_held_actions_is_resumed_as_well(tmp_path, warm):
    """Five steps an action, and episodes of twelve: two steps of each are not learned from."""
    changed = {"agent.action_repeat=1": "agent.action_repeat=5", "agent.sequence_length=8": "agent.sequence_length=3"}
    words = [changed.get(word, word) for word in LEARNER]
    assert warm("explore", *words, f"hydra.run.dir={tmp_path / 'quiet'}").returncode == 0
    killed = warm("training", "explore", *words, f"hydra.run.dir={tmp_path / 'run'}", program=KILLED)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    resumed = warm("resume", str(tmp_path / "run"))
    assert resumed.returncode == 0, resumed.stderr
    ours, quiet = leftovers(tmp_path / "run"), leftovers(tmp_path / "quiet")
    assert [name for name in ours if ours[name] != quiet[name]] == []
    assert quiet["replay"]["steps"] == 4 * 10

@pytest.mark.parametrize("agent", [("agent=random",), ("agent.sequence_length=3", "agent.behaviour=plan")])
def test_a_run_of_options_is_resumed_as_well(tmp_path, agent, warm):
    """Killed in the third of its episodes, in a turn or on a drive; the last option of an episode may be cut off."""
    given = {word.partition("=")[0]: word for word in (*LEARNER, *agent, "agent.options=seven", "loop.steps=40")}
    words = [word for key, word in given.items() if agent[0] != "agent=random" or key in (
        "env", "agent", "loop.steps", "loop.episodes", "agent.options")]
    assert warm("explore", *words, f"hydra.run.dir={tmp_path / 'quiet'}").returncode == 0
    killed = warm("acting", "explore", *words, f"hydra.run.dir={tmp_path / 'run'}",
                      program=KILLED.replace("steps == 24", "steps == 80"))
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    resumed = warm("resume", str(tmp_path / "run"))
    assert resumed.returncode == 0, resumed.stderr
    ours, quiet = leftovers(tmp_path / "run"), leftovers(tmp_path / "quiet")
    assert [name for name in ours if ours[name] != quiet[name]] == []
    episodes = [Episode.load(path) for path in sorted((tmp_path / "run" / "episodes").iterdir())]
    ends = [int(Options().decisions(one.action, one.collided).frame[-1]) for one in episodes]
    assert len(ends) == 4 and all(40 - Options.most < end <= 40 for end in ends)
    if agent[0] != "agent=random":
        assert quiet["replay"]["steps"] == sum(ends)
        assert all("plan_entropy" in row for row in quiet["metrics"])


def test_a_run_from_before_there_were_options_goes_on(tmp_path, warm):
    run, newer = tmp_path / "run", {"options": "none", "behaviour": "actor"}
    assert warm("explore", *LEARNER, "loop.episodes=1", f"hydra.run.dir={run}").returncode == 0
    (save,) = (run / "checkpoint").glob("0*")
    (save / "checksums.json").unlink()
    for path in (run / "fixed.json", save / "settings.json"):
        held = read_json(path)
        assert {key: held["agent"].pop(key) for key in newer} == newer
        assert len([held["agent"].pop(key) for key in list(held["agent"]) if key.startswith("plan_")]) == 3
        path.write_text(json.dumps(held))
    lines = (run / "config.yaml").read_text().splitlines()
    (run / "config.yaml").write_text("\n".join(
        line for line in lines if not line.strip().startswith(("plan_", "options:", "behaviour:"))))
    resumed = warm("resume", str(run), "loop.episodes=2")
    assert resumed.returncode == 0 and "goes on after 1 finished episode" in resumed.stdout, resumed.stderr
    assert "behaviour: actor" in (run / "config.yaml").read_text()


def test_a_run_from_before_actions_were_held_goes_on(tmp_path, warm):
    run = tmp_path / "run"
    assert warm("explore", *LEARNER, "loop.episodes=1", f"hydra.run.dir={run}").returncode == 0
    (save,) = (run / "checkpoint").glob("0*")
    (save / "checksums.json").unlink()
    for path in (run / "fixed.json", save / "settings.json"):
        held = read_json(path)
        assert held["agent"].pop("action_repeat") == 1
        path.write_text(json.dumps(held))
    lines = (run / "config.yaml").read_text().splitlines()
    (run / "config.yaml").write_text("\n".join(line for line in lines if "action_repeat" not in line))
    resumed = warm("resume", str(run), "loop.episodes=2")
    assert resumed.returncode == 0 and "goes on after 1 finished episode" in resumed.stdout, resumed.stderr
    assert "action_repeat: 1" in (run / "config.yaml").read_text()
