"""Commands in processes of their own, forked from a warm one (warm_process.py): what they import is there already."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest


@dataclass
class Warm:
    """warm("explore", "seed=1") -> return code, stdout, stderr of `curionav explore seed=1`, as subprocess.run gives.

    Figures are files without a picture.

    program: Python to run in place of the command line, with the words as its arguments.
    """

    server: subprocess.Popen[str]
    folder: Path

    def __call__(self, *words: str, program: str = "", cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        files = [self.folder / "out", self.folder / "error"]
        order = {"words": words, "program": program, "cwd": str(cwd or Path.cwd()), "environment": dict(os.environ),
                 "files": [str(path) for path in files]}
        assert self.server.stdin is not None and self.server.stdout is not None
        print(json.dumps(order), file=self.server.stdin, flush=True)
        code = json.loads(self.server.stdout.readline())
        return subprocess.CompletedProcess(words, code, *(path.read_text() for path in files))


@pytest.fixture(scope="session")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Warm]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    with subprocess.Popen([sys.executable, Path(__file__).with_name("warm_process.py")], stdin=subprocess.PIPE,
                          stdout=subprocess.PIPE, text=True, env=environment) as server:
        yield Warm(server, tmp_path_factory.mktemp("warm"))
        assert server.stdin is not None
        server.stdin.close()
