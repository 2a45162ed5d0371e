"""Robot and server as commands, in processes of their own: what they make, killed and started again, and what they say
when they cannot."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from deadly import DEADLY
from entry import Cli
from leftovers import repeatable
from tiny import LEARNER, at_storage

from curionav_cli.storage import checkpoint

pytest.importorskip("obstore")
pytestmark = [
    pytest.mark.timeout(900),  # robots and servers wait for each other, whoever else the machine works for
    pytest.mark.usefixtures("blank_figures"),
]

# Kills its own process at a chosen moment of the second episode, as a power cut would.
KILLED = DEADLY + """
from curionav_cli.execution.recorder import Recorder
from curionav_cli.storage import checkpoint
from curionav_cli.remote.inbox import Inbox
from curionav_cli.remote.ledger import Ledger
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.remote.object_store import ObjectStore
second = lambda recorder: recorder.coverage.steps == 12
if moment == "fetched": at(Inbox, "fetch", lambda inbox, name: name.startswith("000001"))
if moment == "taken": at(Ledger, "take", lambda ledger, marker: marker.seq == 1)
if moment == "stored": at(RunFolder, "save_episode", lambda run, index, episode: index == 1)
if moment == "training": at(Recorder, "learned", lambda recorder, i: second(recorder) and i == 2)
if moment == "saving": at(checkpoint, "flush", lambda path: path.parent.name == "000002.part")
if moment == "saved": at(checkpoint, "save", lambda root, done, *more: done == 2)
if moment == "noted": at(Ledger, "publish", lambda ledger, version, sha: version == 2)
if moment == "weights": at(ObjectStore, "put", lambda store, key, raw: key.startswith("weights/000002"))
if moment == "pointer": at(ObjectStore, "put", lambda store, key, raw: key.endswith("LATEST.json") and b": 2" in raw)
app.main()
"""


def command(*line: str, program: tuple[str, ...] = ("-m", "curionav_cli")) -> subprocess.Popen:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "NO_COLOR": "1"}
    return subprocess.Popen([sys.executable, *program, *line], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            text=True, env=environment)


def weights(run: Path) -> dict[str, bytes]:
    """All of the newest checkpoint, but for the settings beside it, and the checksums of all."""
    newest = checkpoint.finished(run / "checkpoint")[-1]
    return {path.name: path.read_bytes() for path in newest.iterdir()
            if path.name not in ("settings.json", "checksums.json")}


def metrics(run: Path) -> list[dict]:
    rows = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    return [{k: v for k, v in row.items() if k not in ("seq", "weights_version")} for row in repeatable(rows)]


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


PLANS = ("agent.options=seven", "agent.behaviour=plan", "agent.sequence_length=3", "loop.steps=120")


@pytest.mark.parametrize("more", [(), pytest.param(PLANS, marks=pytest.mark.slow)], ids=["actor", "plan"])
def test_a_robot_and_a_server_make_what_one_process_makes(cli: Cli, tmp_path: Path, more: tuple[str, ...]) -> None:
    """Byte for byte: weights, optimisers, random states, episodes, predictions; and the metrics but for seconds."""
    storage, kept = (tmp_path / "storage").as_uri(), tmp_path / "storage"
    with command("train", *at_storage(storage, "server", *more), "--follow") as server:
        try:
            robot = cli("explore", *at_storage(storage, "robot", "learner=remote", *more))
        finally:
            server.kill()
    assert robot.code == 0, robot.error
    here_alone = {word.partition("=")[0]: word for word in (*LEARNER, *more, "hydra.run.dir=here")}
    assert cli("explore", *here_alone.values()).code == 0
    here, there, robot = (tmp_path / name for name in ("here", "server", "robot"))
    assert weights(there) == weights(here)
    assert metrics(there) == [{k: v for k, v in row.items() if k != "plan_entropy"} for row in metrics(here)]
    for index in range(4):
        name = f"episodes/{index:06d}.npz"
        assert (robot / name).read_bytes() == (there / name).read_bytes() == (here / name).read_bytes()
        name = f"predictions/{index:06d}.npz"
        assert (there / name).read_bytes() == (here / name).read_bytes()
    rows = [json.loads(line) for line in (robot / "metrics.jsonl").read_text().splitlines()]
    assert [row["weights_version"] for row in rows] == [0, 1, 2, 3]
    assert [name[:6] for name in names(robot / "weights")] == ["000003", "000003", "000004", "000004"]
    assert names(robot / "outbox") == ["sent"] and len(names(robot / "outbox" / "sent")) == 4
    assert len(names(kept / "episodes")) == 8 and "LATEST.json" in names(kept / "weights")
    shared = {path.name for path in kept.rglob("*") if path.suffix not in (".npz", ".json", ".safetensors", "")}
    assert shared == set()


@pytest.fixture(scope="module")
def delivered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A storage with four episodes in it and nobody who has learned from them."""
    folder = tmp_path_factory.mktemp("delivered")
    line = at_storage((folder / "storage").as_uri(), folder / "robot", "learner=remote", "remote.wait=0")
    robot = command("explore", *line)
    said, _ = robot.communicate()
    assert robot.returncode == 0 and "no new weights after 0 s: goes on with weights 0" in said, said
    return folder / "storage"


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory, delivered: Path) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("quiet")
    shutil.copytree(delivered, folder / "storage")
    server = command("train", *at_storage((folder / "storage").as_uri(), folder / "server"))
    said, _ = server.communicate()
    assert server.returncode == 0 and "4 episodes learned" in said, said
    return weights(folder / "server")


@pytest.mark.slow
@pytest.mark.parametrize("moment", [
    "fetched", "taken", "stored", "training", "saving", "saved", "noted", "weights", "pointer"])
def test_a_killed_server_ends_as_a_quiet_one(
        tmp_path: Path, delivered: Path, quiet: dict[str, bytes], moment: str) -> None:
    """SIGKILL at every boundary; the same command again, and each episode was learned from once."""
    shutil.copytree(delivered, tmp_path / "storage")
    line = at_storage((tmp_path / "storage").as_uri(), tmp_path / "server")
    killed = command(moment, "train", *line, program=("-c", KILLED))
    said, _ = killed.communicate()
    assert killed.returncode == -signal.SIGKILL, said
    again = command("train", *line)
    said, _ = again.communicate()
    assert again.returncode == 0, said
    assert weights(tmp_path / "server") == quiet
    assert [row["episode"] for row in metrics(tmp_path / "server")] == [0, 1, 2, 3]
    kept = [name for name in names(tmp_path / "storage" / "weights") if name.endswith("safetensors")]
    assert [name[:6] for name in kept] == ["000002", "000003", "000004"]
    assert '"version": 4' in (tmp_path / "storage" / "weights" / "LATEST.json").read_text()


@pytest.mark.slow
def test_a_killed_robot_runs_its_episode_again_as_it_was(tmp_path: Path, cli: Cli, quiet: dict[str, bytes]) -> None:
    """Newer weights came meanwhile, and wait until the episode was run again: nothing comes twice."""
    storage, robot = (tmp_path / "storage").as_uri(), tmp_path / "robot"
    fallen = KILLED.replace('if moment == "fetched"', """
if moment == "checkpoint": at(RunFolder, "append_metrics", lambda run, row: row["episode"] == 2)
if moment == "fetched\"""")
    line = at_storage(storage, robot, "learner=remote", "remote.wait=0")
    killed = command("checkpoint", "explore", *line, program=("-c", fallen))
    said, _ = killed.communicate()
    assert killed.returncode == -signal.SIGKILL, said
    assert names(robot / "outbox")[0].startswith("000002-")
    assert cli("train", *at_storage(storage, "server")).code == 0
    assert cli("explore", *line).code == 0
    served = cli("train", *at_storage(storage, "server"))
    assert served.code == 0 and "came twice" not in served.out, served.out
    assert len(names(tmp_path / "storage" / "episodes")) == 8 and len(metrics(tmp_path / "server")) == 4


@pytest.mark.slow
@pytest.mark.timeout(3000)
@pytest.mark.parametrize("kind", ["folder", "rclone", "moto"])
def test_twenty_episodes_with_a_server_that_is_killed_five_times(
        cli: Cli, tmp_path: Path, request: pytest.FixtureRequest, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The robot waits for its server, which dies after 2, 5, 9, 13 and 16 episodes, somewhere in the next one."""
    from servers import a_place

    place = a_place(kind, request, tmp_path, monkeypatch)
    long = ("loop.episodes=20", "remote.wait=2500")
    assert cli("explore", *at_storage("null", "here", *long)).code == 0
    with command("explore", *at_storage(place.url, tmp_path / "robot", "learner=remote", *long)) as robot:
        for until in (2, 5, 9, 13, 16, 20):
            with command("train", *at_storage(place.url, tmp_path / "server"), "--follow") as server:
                wait_for(tmp_path / "server", until, server, robot)
                if until == 20:
                    robot.wait()
                server.kill()
        said = robot.stdout.read() if robot.stdout else ""
    assert robot.returncode == 0, said
    assert weights(tmp_path / "server") == weights(tmp_path / "here")
    assert metrics(tmp_path / "server") == metrics(tmp_path / "here")


def wait_for(run: Path, episodes: int, server: subprocess.Popen, robot: subprocess.Popen) -> None:
    """Until the server has learned from so many, and a little longer: into the middle of something."""
    while True:
        done = checkpoint.finished(run / "checkpoint")
        if done and int(done[-1].name) >= episodes:
            time.sleep(0.03)
            return
        assert server.poll() is None and (robot.poll() is None or episodes == 20)
        time.sleep(0.02)


@pytest.mark.slow
def test_a_storage_of_another_run_is_named_by_what_differs(cli: Cli, tmp_path: Path, delivered: Path) -> None:
    shutil.copytree(delivered, tmp_path / "storage")
    storage = (tmp_path / "storage").as_uri()
    other = cli("train", *at_storage(storage, "server", "agent.horizon=5"))
    assert other.code == 2 and "storage: it is used with other settings: agent.horizon was 4, now 5." in other.error
    fresh = cli("explore", *at_storage(storage, "second", "learner=remote"))
    assert fresh.code == 2 and "holds the episodes of another run. Resume that run, or use an" in fresh.error
    assert len(fresh.error.strip().splitlines()) == 1
