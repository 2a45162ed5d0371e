"""For all tests: one thread, no settings of the user, a terminal of known width."""

from __future__ import annotations

import gc
import os

import pytest

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

pytest_plugins = ["browsing", "commandline", "composing", "sample_records", "servers", "warm"]


def pytest_collection_finish() -> None:
    """Take what all tests imported out of the garbage collector's rounds; OmegaConf's many objects begin one often."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.fixture(autouse=True)
def clean_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("CURIONAV_CONFIG_PATH", "COMP_WORDS", "COMP_CWORD", "FORCE_COLOR", "GITHUB_ACTIONS"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("NO_COLOR", "1")
    monkeypatch.setenv("COLUMNS", "120")
