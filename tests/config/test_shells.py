"""Completion in zsh and fish themselves, at a terminal, by what --install-completion and docs/install.md say."""

from __future__ import annotations

import os
import pty
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow
BIN = Path(sys.executable).parent
SECONDS = 120  # that a loaded machine may take to answer
ZSHRC = """PS1=""
autoload -Uz compinit && compinit -u
source <(curionav --show-completion zsh)
show () { print -r -- "$BUFFER" > "$HOME/line.new" && mv "$HOME/line.new" "$HOME/line"; BUFFER="" }
zle -N show
bindkey '^I' complete-word
bindkey '^X' show
touch "$HOME/ready"
"""
TYPED = {
    "env=sm": "env=small_room", "loop.ste": "loop.steps=",
    "agent=mapper agent.goal=f": "agent=mapper agent.goal=frontier",
    "-m agent=random,bo": "-m agent=random,bounce"}


@pytest.mark.skipif(not shutil.which("fish"), reason="needs fish")
def test_fish(tmp_path: Path) -> None:
    env = {**os.environ, "HOME": str(tmp_path), "PATH": f"{BIN}:{os.environ['PATH']}"}
    env.pop("XDG_CONFIG_HOME", None)
    asked = "; ".join(f"complete -C 'curionav explore {typed}'; echo END" for typed in TYPED)
    for command in ("curionav --install-completion fish", asked):
        done = subprocess.run(["fish", "-c", command], env=env, capture_output=True, text=True, check=True)
    offered = [part.split() for part in done.stdout.split("END\n")]
    assert [words[0] for words in offered[:-1]] == [completed.split()[-1] for completed in TYPED.values()]


@pytest.mark.skipif(not shutil.which("zsh"), reason="needs zsh")
def test_zsh(tmp_path: Path) -> None:
    (tmp_path / ".zshrc").write_text(ZSHRC)
    with zsh(tmp_path) as terminal:
        wait_for(tmp_path / "ready", terminal)
        for typed, completed in TYPED.items():
            os.write(terminal, f"curionav explore {typed}\t\x18".encode())
            line = wait_for(tmp_path / "line", terminal)
            space = "" if completed.endswith("=") else " "  # a key is followed by its value, without a space
            assert line == f"curionav explore {completed}{space}\n"


@contextmanager
def zsh(home: Path) -> Iterator[int]:
    """A zsh of this home folder at a terminal of its own, whose other end is the file descriptor."""
    ours, theirs = pty.openpty()
    env = {**os.environ, "HOME": str(home), "ZDOTDIR": str(home), "TERM": "dumb", "PATH": f"{BIN}:{os.environ['PATH']}"}
    with subprocess.Popen(["zsh", "-i"], env=env, stdin=theirs, stdout=theirs, stderr=theirs,
                          start_new_session=True) as shell:
        try:
            yield ours
        finally:
            shell.kill()
            os.close(theirs)
            os.close(ours)


def wait_for(file: Path, terminal: int) -> str:
    """The text of a file once it is there, which it then is no longer; what the shell prints meanwhile is read away."""
    end = time.monotonic() + SECONDS
    printed = b""
    while not file.exists():
        assert time.monotonic() < end, printed
        if select.select([terminal], [], [], 0.1)[0]:
            printed += os.read(terminal, 4096)
    text = file.read_text()
    file.unlink()
    return text
