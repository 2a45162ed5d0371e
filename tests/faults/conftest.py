"""A warm process that runs commands in forks of itself, for all tests of faults."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from entry import Answer

VICTIM = Path(__file__).with_name("victim.py")


@dataclass
class Forks:
    """forks("explore", "seed=1", phase="saving", at=100) -> exit code, stdout, stderr; events: of the last command."""

    server: subprocess.Popen[str]
    folder: Path
    events: dict[str, int]

    def __call__(self, *words: str, phase: str = "", at: int | None = None) -> Answer:
        files = [self.folder / "out", self.folder / "error"]
        assert self.server.stdin is not None and self.server.stdout is not None
        order = {"words": words, "phase": phase, "at": at, "files": [str(path) for path in files]}
        print(json.dumps(order), file=self.server.stdin, flush=True)
        told = json.loads(self.server.stdout.readline())
        self.events = told["events"]
        return Answer(told["code"], *(path.read_text() for path in files))


@pytest.fixture(scope="session")
def forks(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., Answer]]:
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "NO_COLOR": "1", "COLUMNS": "120"}
    with subprocess.Popen([sys.executable, VICTIM], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                          env=environment) as server:
        yield Forks(server, tmp_path_factory.mktemp("said"), {})
        assert server.stdin is not None
        server.stdin.close()
