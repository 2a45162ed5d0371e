"""What robot and server say when they cannot: wrong words before anything is written, one line for a storage that
denies, and no key anywhere."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from entry import Cli
from servers import free_port
from tiny import at_storage

pytest.importorskip("obstore")
pytestmark = [pytest.mark.timeout(900), pytest.mark.usefixtures("blank_figures")]

SECRET = "wJalrXUtnFEMI"


@pytest.mark.parametrize(("line", "said"), [
    (("explore", "learner=remote"), "learner=remote needs a storage for robot and server: storage=file:///"),
    (("explore", "storage=file:///x"), "Add learner=remote"),
    (("explore", "learner=remote", f"storage=s3://AKIA:{SECRET}@bucket/x"), "keys and passwords do not belong into a"),
    (("explore", "learner=remote", "storage=file:///x", "agent=random"), "agent=random does not learn, so no server"),
    (("explore", "learner=remote", "storage=file:///x", "agent=cbet"), "learns only from the episode it has just run"),
    (("explore", "learner=remote", "storage=file:///x", "loop.iterations=0"), "loop.iterations=0 trains nothing"),
    (("train", "storage=file:///x", "data=y"), "data=... and storage=... are two places to learn from"),
    (("train", "storage=file:///x", "learner=remote"), "learner=remote is for the robot, curionav explore"),
])
def test_what_cannot_be_meant_is_answered_before_anything_is_written(
        cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: tuple[str, ...], said: str) -> None:
    for name in [name for name in os.environ if name.startswith("AWS_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("AWS_ENDPOINT_URL", "http://127.0.0.1:9")
    answer = cli(line[0], "hydra.run.dir=run", *line[1:])
    assert answer.code == 2 and said in answer.error, answer.error
    assert len(answer.error.strip().splitlines()) <= 2 and SECRET not in answer.error + answer.out
    assert not (tmp_path / "run").exists()


def test_places_that_are_no_storage_begin_no_run(cli: Cli, tmp_path: Path) -> None:
    """A file where the folder should be; a folder of another run."""
    (tmp_path / "file").touch()
    for line in (("explore", "learner=remote"), ("train",)):
        answer = cli(line[0], *at_storage("file:///proc/none", line[0], *line[1:]))
        assert answer.code == 2
        assert answer.error == "storage: file:///proc/none cannot be used: its folder cannot be made.\n"
        answer = cli(line[0], *at_storage((tmp_path / "file").as_uri(), line[0], *line[1:]))
        assert answer.code == 2 and answer.error.strip() == (
            f"storage: {(tmp_path / 'file').as_uri()} cannot be used: it is a file, or lies in one.")
        assert not list(tmp_path.glob("*/episodes/*"))


def test_episodes_that_stay_in_the_outbox_are_reported_at_the_end(cli: Cli, tmp_path: Path) -> None:
    """Of a run that is done but for that; the same command delivers them."""
    away = tmp_path / "storage"
    away.touch()
    line = ("explore", *at_storage(away.as_uri(), "robot", "learner=remote", "remote.offline=0", "remote.wait=0",
                                   "loop.episodes=2"))
    run = tmp_path / "robot"
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("curionav_cli.execution.remote_setup.refuse_denied", lambda settings, error: None)
        alone = cli(*line)
    assert alone.code == 1 and f"2 episodes could not be delivered and wait in {run / 'outbox'}." in alone.error
    assert (run / "figures" / "coverage.png").exists() and len(list((run / "outbox").glob("*.npz"))) == 2
    away.unlink()
    assert cli(*line).code == 0 and not list((run / "outbox").glob("*.npz"))
    assert len(list((away / "episodes").glob("*.json"))) == 2


def test_no_key_is_in_any_file_or_line(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a robot and a server whose storage refuses them, repeating their signature in its answer."""
    from bad_server import BadServer, Fault

    monkeypatch.setenv("AWS_ACCESS_KEY_ID", "AKIA" + SECRET)
    monkeypatch.setenv("AWS_SECRET_ACCESS_KEY", SECRET * 2)
    with BadServer().running() as bad:
        monkeypatch.setenv("AWS_ENDPOINT_URL", bad.endpoint)
        bad.faults = [Fault("status", method, times=10**6, status=403, code="AccessDenied")
                      for method in ("GET", "PUT", "HEAD", "DELETE")]
        refused = [cli("explore", *at_storage("s3://bucket/run", "fresh", "learner=remote")),
                   cli("train", *at_storage("s3://bucket/run", "server"))]
        outbox = ("learner=remote", "remote.offline=0", "remote.outbox=1", "loop.iterations=1")
        monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://127.0.0.1:{free_port()}")
        alone = cli("explore", *at_storage("s3://bucket/run", "robot", *outbox))
        server = cli("train", *at_storage("s3://bucket/run", "server"))
        monkeypatch.setenv("AWS_ENDPOINT_URL", bad.endpoint)
        robot = cli("explore", *at_storage("s3://bucket/run", "robot", *outbox))
    for answer in refused:
        assert answer.code == 2 and answer.error == "storage: s3://bucket/run cannot be used: it refuses our key.\n"
    for answer, why in ((alone, "the connection was refused"), (robot, "it refuses our key")):
        assert answer.code == 1 and "The outbox is full: 1 episodes wait" in answer.error
        assert f"the storage is not reachable ({why}): goes on with weights 0" in answer.out
    assert server.code == 1 and "The storage is not reachable (the connection was refused)" in server.error
    seen = "".join(answer.out + answer.error for answer in (*refused, alone, server, robot))
    for path in tmp_path.rglob("*"):
        if path.is_file():
            seen += path.read_bytes().decode("latin-1")
    assert SECRET not in seen and "Signature=" not in seen and "AWS4-HMAC" not in seen
