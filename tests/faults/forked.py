"""Commands in forks of a warm process (victim.py), as the tests of faults call them."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path

from entry import Answer


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
        reply = json.loads(self.server.stdout.readline())
        self.events = reply["events"]
        return Answer(reply["code"], *(path.read_text() for path in files))
