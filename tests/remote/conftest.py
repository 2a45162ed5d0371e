"""Each kind of storage; and a robot and a server that need no torch and no waiting."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from remote.pair import Pair
from servers import Place, a_place

collect_ignore_glob = [] if find_spec("obstore") else ["test_*.py"]
FULL = pytest.mark.slow


@pytest.fixture(params=["folder", "bad", pytest.param("rclone", marks=FULL), pytest.param("moto", marks=FULL)])
def place(request: pytest.FixtureRequest, no_credentials: None, tmp_path: Path,
          monkeypatch: pytest.MonkeyPatch) -> Place:
    """Each kind of storage, empty; the environment says how to reach it."""
    return a_place(request.param, request, tmp_path, monkeypatch)


@pytest.fixture(params=["rclone", "moto"])
def real(request: pytest.FixtureRequest, no_credentials: None, tmp_path: Path,
         monkeypatch: pytest.MonkeyPatch) -> Place:
    """The two S3 servers of others, for the few tests that run on them each time."""
    return a_place(request.param, request, tmp_path, monkeypatch)


@pytest.fixture
def pair(place: Place, tmp_path: Path, an_episode) -> Iterator[Pair]:
    """A robot and a server at that storage."""
    with Pair(place.url, tmp_path, an_episode).at_work() as both:
        yield both
