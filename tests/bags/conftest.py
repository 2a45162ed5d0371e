"""Bags need rosbags, an extra; episodes of bags are kept in a cache of the test's own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rosbags")

from drives import Drive, mcap

from curionav_cli.bags import source
from curionav_cli.bags.intake import episodes
from curionav_cli.records import Episode

Read = Callable[..., tuple[list[Episode], dict[str, Any]]]


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """read(bag or drive) -> its episodes, in this process, and the report."""
    def call(bag: Path | Drive, sources=None):
        path = bag if isinstance(bag, Path) else mcap(tmp_path / f"made_{len(list(tmp_path.iterdir()))}", bag)
        report: dict[str, Any] = {}
        return list(episodes(path, sources or source.known(), report)), report
    return call
