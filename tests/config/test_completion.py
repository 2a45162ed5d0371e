"""Completion as shells ask for it: bash, which cuts words at '='; zsh and fish, which give whole ones."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from entry import Cli

SCRIPT = """
eval "$(_CURIONAV_COMPLETE=source_bash curionav)"
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
_curionav_completion curionav
printf '%s\\n' "${COMPREPLY[@]}"
"""
BIN = Path(sys.executable).parent

pytestmark = pytest.mark.skipif(
    shutil.which("bash") is None or not (BIN / "curionav").exists(), reason="needs bash and the script")


def bash(*words: str) -> list[str]:
    """What bash would offer for these words, the last one being completed."""
    env = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}
    command = ["bash", "--norc", "-c", SCRIPT, "bash", "curionav", *words]
    return subprocess.run(command, env=env, capture_output=True, text=True, check=True).stdout.split()


TYPED = {
    "exp": ["explore", "export"],
    "explore env = sm": ["small_room"],
    "explore env=sm": ["env=small_room"],
    "explore agent = random env = sm": ["small_room"],
    "explore -m agent = random,bo": ["random,bounce"],
    "explore agent = sticky agent.re": ["agent.repeat=", "agent.repeat=0.75"],
    "explore device =": ["auto", "cpu", "cuda"],
    "runs --st": ["--state"],
    "coverage --marking s": ["swept"],
    "explore compile =": ["auto", "none", "graph", "fused"],
    "explore env.collision = s": ["stop", "slide"],
    "explore loop.ste": ["loop.steps=", "loop.steps=500"],
    "explore storag": ["storage=", "storage=null"],
    "explore agent = mapper agent.goal =": ["unvisited", "frontier", "information"],
    "explore -m agent = curious_mapper agent.surprise = visits,": ["visits,measured", "visits,shuffled"],
    "explore -m agent = mapper,curious_mapper agent.re": ["agent.reach=", "agent.reach=5.0"],
    "paper fig": ["figures"],
    "paper figures ": [],
    "list e": ["env", "experiment"],
    "explore --mul": ["--multirun"],
    "explore schem": [],
    "explore agent = unheard env = sm": ["small_room"],
}


@pytest.mark.parametrize("typed", [typed for typed in TYPED if "random" in typed])
def test_bash(typed: str) -> None:
    """Where bash cuts a word at '=' and at ','; what else the script is told is asked below, without a process."""
    assert bash(*typed.split()) == TYPED[typed]


@pytest.mark.parametrize("typed", TYPED)
def test_what_the_script_is_told(cli: Cli, monkeypatch: pytest.MonkeyPatch, typed: str) -> None:
    """As the script of bash asks, without a process."""
    words = ["curionav", *typed.split(), *[""] * typed.endswith(" ")]
    asked = {"_CURIONAV_COMPLETE": "complete_bash", "COMP_WORDS": "\n".join(words), "COMP_CWORD": str(len(words) - 1)}
    assert answered(cli, monkeypatch, asked).split() == TYPED[typed]


@pytest.mark.parametrize(("shell", "said"), [
    ("zsh", """_arguments '*: :(("loop.steps="\n"loop.steps=500"))'"""), ("fish", "loop.steps=\nloop.steps=500")])
def test_zsh_and_fish_are_given_whole_words(
        cli: Cli, monkeypatch: pytest.MonkeyPatch, shell: str, said: str) -> None:
    asked = {"_CURIONAV_COMPLETE": f"complete_{shell}", "_TYPER_COMPLETE_ARGS": "curionav explore env=hall loop.ste",
             "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    assert answered(cli, monkeypatch, asked).strip() == said


def answered(cli: Cli, monkeypatch: pytest.MonkeyPatch, asked: dict[str, str]) -> str:
    """What is printed for a shell that asks by these variables."""
    for name, value in asked.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(sys, "argv", ["curionav"])  # by which click knows whose completion is asked
    monkeypatch.setattr(sys.modules["__main__"], "__package__", None)
    return cli().out


def test_a_users_directory_is_completed_too(tmp_path: Path) -> None:
    (tmp_path / "agent").mkdir()
    (tmp_path / "agent" / "stubborn.yaml").write_text("defaults:\n  - sticky\n")
    assert bash("explore", "-cd", str(tmp_path), "agent", "=", "stu") == ["stubborn"]
