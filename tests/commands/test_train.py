"""curionav train: from stored episodes to a checkpoint, killed and resumed, and what it says when it cannot."""

from __future__ import annotations

import json
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from deadly import DEADLY
from entry import Cli
from leftovers import repeatable
from paint import unpainted
from tiny import LEARNER
from warm import Warm

from curionav_cli import build
from curionav_cli.app import main
from curionav_cli.config.settings import read_settings
from curionav_cli.execution import training
from curionav_cli.records import Episode
from curionav_cli.storage import checkpoint
from curionav_cli.storage.run_folder import RunFolder

pytestmark = pytest.mark.usefixtures("blank_figures")
TINY = tuple(word for word in LEARNER if not word.startswith("loop."))

# A save after every third iteration; kills its own process at a chosen moment, as a power cut would.
KILLED = DEADLY + """

from curionav_cli.execution import training
from curionav_cli.execution.recorder import TrainRecorder
from curionav_cli.storage import checkpoint
from curionav_cli.storage.run_folder import RunFolder

training.EVERY = 3
if moment == "training": at(TrainRecorder, "learned", lambda study, i: study.run.metrics() and i == 2)
if moment == "saving": at(checkpoint, "flush", lambda path: path.parent.name == "000006.part")
if moment == "between": at(RunFolder, "append_metrics", lambda run, row: row["iterations"] == 6)
if moment == "beginning": at(RunFolder, "create", lambda run, *words: True)
app.main()
"""


@pytest.fixture(scope="module")
def explored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of three episodes of 12 steps in the small room."""
    run = tmp_path_factory.mktemp("explored") / "run"
    with unpainted():
        assert here("explore", "agent=random", "loop.steps=12", "loop.episodes=3", f"hydra.run.dir={run}") == 0
    return run


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(training, "EVERY", 3)


def here(*words: str) -> int | str | None:
    """The exit code."""
    with pytest.raises(SystemExit) as stop:
        main(list(words))
    return stop.value.code


def rows(run: Path) -> list[dict]:
    return [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]


def status(run: Path) -> dict:
    return RunFolder(run).status


def leftovers(run: Path) -> dict:
    """All that a training leaves behind, without what was measured of the process."""
    files: dict = {str(path.relative_to(run)): path.read_bytes()
                   for path in sorted((run / "checkpoint").rglob("*")) if path.is_file()}
    files["metrics"] = repeatable(rows(run))
    return {**files, "status": status(run), "fixed": (run / "fixed.json").read_bytes()}


def test_a_training_leaves_what_an_exploration_leaves_but_for_episodes(cli: Cli, explored: Path, often: None) -> None:
    answer = cli("train", *TINY, f"data={explored}", "loop.iterations=7", "hydra.run.dir=trained")
    assert answer.code == 0, answer.error
    run = Path("trained").absolute()
    assert [row["iterations"] for row in rows(run)] == [3, 6, 7]
    assert all(np.isfinite(row["model_loss"]) and row["seconds_learning"] > 0 for row in rows(run))
    assert [folder.name for folder in checkpoint.finished(run / "checkpoint")] == ["000006", "000007"]
    frames = 3 * 13 * 64 * 64 * 3
    assert status(run) == {
        "state": "done", "error": None, "iteration": 7, "iterations": 7,
        "replay": {"episodes": 3, "steps": 36, "bytes_in_memory": frames, "bytes_on_disk": 0}}
    assert json.loads((run / "run.json").read_text())["command"].startswith("curionav train env=small_room")
    assert "iteration 6/7" in answer.out and "curionav resume trained loop.iterations=" in answer.out
    assert not (run / "episodes").exists()
    answer = cli("coverage", "trained")
    assert answer.code == 2 and "offline training runs no episodes" in answer.error
    assert len(answer.error.splitlines()) == 1


def test_its_checkpoint_is_that_of_an_exploration(cli: Cli, explored: Path) -> None:
    """What it learned acts in the world, as an agent that is loaded to resume a run does."""
    words = (f"data={explored}", "loop.iterations=4", "hydra.run.dir=trained")
    assert cli("train", *TINY, *words).code == 0
    settings = read_settings(Path("trained/config.yaml"))
    world, folder = build.scene(settings), checkpoint.finished(Path("trained/checkpoint"))[-1]
    assert folder.name == "000004"
    agent = build.agent(settings, world)
    agent.load(folder)
    observation, info = build.env(settings, world).reset(seed=0)
    agent.begin()
    assert agent.act(observation, info) in (0, 1, 2)
    longer = build.agent(replace(settings, seed=1), world)
    longer.load(folder)
    longer.save(Path.cwd())
    assert Path("weights.safetensors").read_bytes() == (folder / "weights.safetensors").read_bytes()


def test_a_run_a_sweep_and_a_folder_of_episodes_serve(cli: Cli, explored: Path, tmp_path: Path) -> None:
    shutil.copytree(explored, tmp_path / "sweep" / "0_a")
    shutil.copytree(explored, tmp_path / "sweep" / "1_b")
    for name, data, steps in (("run", explored, 36), ("folder", explored / "episodes", 36), ("sweep", "sweep", 72)):
        answer = cli("train", *TINY, f"data={data}", "loop.iterations=2", f"hydra.run.dir={name}")
        assert answer.code == 0, answer.error
        assert status(tmp_path / name)["replay"]["steps"] == steps
    weights = [(tmp_path / name / "checkpoint" / "000002" / "weights.safetensors").read_bytes()
               for name in ("run", "folder", "sweep")]
    assert weights[0] == weights[1] != weights[2]


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory, explored: Path) -> dict:
    run = tmp_path_factory.mktemp("undisturbed") / "run"
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(training, "EVERY", 3)
        assert here("train", *TINY, f"data={explored}", "loop.iterations=9", f"hydra.run.dir={run}") == 0
    return leftovers(run)


@pytest.mark.parametrize("moment", [
    "between", *(pytest.param(moment, marks=pytest.mark.slow) for moment in ("beginning", "training", "saving"))])
def test_a_killed_training_ends_as_an_undisturbed_one(
        cli: Cli, tmp_path: Path, explored: Path, undisturbed: dict, often: None, warm: Warm, moment: str) -> None:
    """Also where the data has grown meanwhile, moved, and stands on the disk."""
    data, run = tmp_path / "data", tmp_path / "run"
    shutil.copytree(explored, data)
    words = ("train", *TINY, f"data={data}", "loop.iterations=9", "loop.replay_memory=0", f"hydra.run.dir={run}")
    killed = warm(moment, *words, program=KILLED)
    assert killed.returncode == -signal.SIGKILL, killed.stderr
    shutil.copy(data / "episodes" / "000000.npz", data / "episodes" / "000003.npz")
    data.rename(tmp_path / "moved")
    resumed = cli("resume", str(run), f"data={tmp_path / 'moved'}", "loop.replay_memory=1")
    assert resumed.code == 0, resumed.error
    ours = leftovers(run)
    assert [name for name in ours.keys() | undisturbed.keys() if ours.get(name) != undisturbed.get(name)] == []


def test_a_finished_training_returns_at_once_and_may_become_longer(
        cli: Cli, explored: Path, undisturbed: dict, often: None, tmp_path: Path) -> None:
    words = ("train", *TINY, f"data={explored}", "loop.iterations=6", "hydra.run.dir=run")
    assert cli(*words).code == 0
    before = (tmp_path / "run" / "metrics.jsonl").stat().st_mtime_ns
    assert cli(*words).code == 0 and cli("resume", "run").code == 0
    assert (tmp_path / "run" / "metrics.jsonl").stat().st_mtime_ns == before
    assert cli("resume", "run", "loop.iterations=9").code == 0
    ours = leftovers(tmp_path / "run")
    assert [name for name in ours if ours[name] != undisturbed[name]] == []
    refused = cli("resume", "run", "loop.episodes=4")
    assert refused.code == 2 and "What may change: loop.iterations, data, init, env.map" in refused.error


def test_changed_episodes_are_refused_by_name(cli: Cli, explored: Path, tmp_path: Path) -> None:
    shutil.copytree(explored, tmp_path / "data")
    assert cli("train", *TINY, "data=data", "loop.iterations=2", "hydra.run.dir=run").code == 0
    shutil.copy(tmp_path / "data" / "episodes" / "000000.npz", tmp_path / "data" / "episodes" / "000001.npz")
    refused = cli("resume", "run", "loop.iterations=4")
    assert refused.code == 2 and "episodes.episodes/000001.npz was" in refused.error
    (tmp_path / "data" / "episodes" / "000001.npz").unlink()
    refused = cli("resume", "run", "loop.iterations=4")
    assert refused.code == 2 and "000001.npz is not whole" in refused.error
    shutil.rmtree(tmp_path / "data")
    refused = cli("resume", "run", "loop.iterations=4")
    assert refused.code == 2 and "If it moved, name it: data=" in refused.error
    assert len(refused.error.splitlines()) == 1


def test_a_sweep_of_trainings(cli: Cli, explored: Path, tmp_path: Path) -> None:
    answer = cli("train", "-m", *TINY, f"data={explored}", "seed=0,1", "loop.iterations=2", "hydra.sweep.dir=sweep")
    assert answer.code == 0, answer.error
    runs = sorted((tmp_path / "sweep").glob("*/status.json"))
    assert [status(path.parent)["iteration"] for path in runs] == [2, 2]
    again = cli("resume", "sweep", "loop.iterations=3")
    assert again.code == 0, again.error
    assert [status(path.parent)["iteration"] for path in runs] == [3, 3]


def harmed(folder: Path, explored: Path, harm: str) -> None:
    """A folder of episodes with something wrong in it."""
    folder.mkdir()
    source = explored / "episodes" / "000000.npz"
    if harm == "torn":
        (folder / "a.npz").write_bytes(source.read_bytes()[:-40])
    if harm == "flipped":
        body = source.read_bytes()
        (folder / "a.npz").write_bytes(body[:200] + b"\0" * 40 + body[240:])
    if harm == "small":
        episode = Episode.load(source)
        replace(episode, image=episode.image[:, ::2, ::2].copy()).save(folder / "a.npz")
    if harm == "hole":
        shutil.copytree(explored, folder, dirs_exist_ok=True)
        (folder / "episodes" / "000001.npz").unlink()
    if harm == "plan":
        shutil.copy(explored / "plan.npz", folder)


@pytest.mark.parametrize(("harm", "words", "said"), [
    ("", (), "data holds no episodes"),
    ("torn", (), "a.npz is not whole"),
    ("flipped", (), "a.npz is not whole"),
    ("small", (), "a.npz holds no episode: its images are uint8 (13, 32, 32, 3)"),
    ("plan", (), "plan.npz is not whole"),
    ("hole", (), "data/episodes/000001.npz is missing, and 000002.npz is there"),
    ("", ("data=nowhere",), "nowhere."),
    ("", ("data=null",), "train needs data"),
    ("", ("data=DATA", "loop.iterations=0"), "loop.iterations=0 trains nothing"),
    ("", ("data=DATA", "agent.sequence_length=14"), "agent.sequence_length=14 does not fit into the longest episode"),
    ("", ("data=DATA", "agent.action_repeat=2", "agent.sequence_length=4"),
     "was recorded without agent.action_repeat=2: its actions are not held for 2 steps"),
    ("", ("data=DATA", "env=large_lab"), "was recorded in small_room, not in large_lab. Add env=small_room"),
])
def test_what_cannot_be_trained_from_is_answered_in_one_line(
        cli: Cli, explored: Path, tmp_path: Path, harm: str, words: tuple[str, ...], said: str) -> None:
    harmed(tmp_path / "data", explored, harm)
    given = {word.partition("=")[0]: word.replace("DATA", str(explored)) for word in ("data=data", *TINY, *words)}
    answer = cli("train", *given.values(), "hydra.run.dir=run")
    assert answer.code == 2 and said in answer.error, answer.error
    assert len(answer.error.strip().splitlines()) == 1
    if harm not in ("flipped", "small"):  # only loading all images shows these
        assert not (tmp_path / "run").exists()


def test_an_agent_that_does_not_learn_is_not_trained_and_exploring_needs_no_data(cli: Cli, explored: Path) -> None:
    for agent, said in (("random", "does not learn,"), ("cbet", "learns only from the episode it has just run,")):
        answer = cli("train", f"agent={agent}", f"data={explored}")
        assert answer.code == 2 and answer.error.startswith(f"agent={agent} {said}")
        assert len(answer.error.splitlines()) == 1
    answer = cli("explore", "agent=random", f"data={explored}")
    assert answer.code == 2 and answer.error.startswith("data=... is for curionav train")


def test_a_full_disk_ends_a_training_as_it_ends_an_exploration(
        cli: Cli, explored: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")
    words = ("train", *TINY, f"data={explored}", "loop.iterations=2", "loop.replay_memory=0", "hydra.run.dir=run")
    with monkeypatch.context() as patched:
        patched.setattr("curionav_cli.storage.scratch.os.pwrite", full)
        answer = cli(*words)
    assert answer.code == 1 and "The disk is full" in answer.error and "Traceback" not in answer.error
    assert status(Path("run"))["state"] == "failed"
    assert cli("resume", "run").code == 0 and status(Path("run"))["state"] == "done"
