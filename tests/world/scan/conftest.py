"""Surveys of scans go where the test is, not into the user's cache."""

from __future__ import annotations

from pathlib import Path

import pytest

from curionav_cli.places import cache_dir


@pytest.fixture(autouse=True)
def kept(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The folder of the surveys that a test keeps."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "kept"))
    return cache_dir("scans")
