"""A warm process that runs commands in forks of itself, for all tests of faults."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from forked import Forks

VICTIM = Path(__file__).with_name("victim.py")


@pytest.fixture(scope="session")
def forks(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forks]:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "NO_COLOR": "1", "COLUMNS": "120"}
    with subprocess.Popen([sys.executable, VICTIM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                          env=environment) as server:
        yield Forks(server, tmp_path_factory.mktemp("said"), {})
        assert server.stdin is not None
        server.stdin.close()
