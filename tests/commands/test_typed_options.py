"""The commands that read runs have real options: in --help, completed, mistyped ones answered; KEY=VALUE works too."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pytest
import typer
from entry import Cli

from curionav_cli.app import app
from curionav_cli.storage.run_folder import RunFolder

COMMANDS = ("runs", "coverage", "compare", "export", "paper")


def choices(command: str) -> dict[str, tuple[str, ...]]:
    return importlib.import_module(f"curionav_cli.commands.{command}").CHOICES


@pytest.mark.parametrize("command", COMMANDS)
def test_help_lists_every_option_and_every_value(cli: Cli, command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    page = cli(command, "--help").out
    for key, values in choices(command).items():
        line = next(line for line in page.splitlines() if f"--{key} " in line)
        assert all(value in line for value in values), line


@pytest.mark.parametrize("command", COMMANDS)
def test_the_shell_completes_values_of_options(command: str) -> None:
    root: Any = typer.main.get_command(app)
    context = root.make_context("curionav", [command], resilient_parsing=True)
    options = {option.name: option for option in root.get_command(context, command).params}
    for key, values in choices(command).items():
        assert [item.value for item in options[key].shell_complete(context, "")] == list(values)


def a_run(path: Path, seed: int, **status: object) -> None:
    path.mkdir(parents=True)
    (path / "config.yaml").write_text(
        f"env: {{name: small_room}}\nagent: {{name: random}}\nrobot: {{name: ideal}}\nseed: {seed}\n")
    (path / "run.json").write_text("{}")
    RunFolder(path).set_status(**status)


def test_an_option_does_what_the_word_does(cli: Cli, tmp_path: Path) -> None:
    a_run(tmp_path / "outputs" / "a", 1, state="done", coverage=0.25)
    a_run(tmp_path / "outputs" / "b", 2, state="failed", coverage=0.5)
    a_run(tmp_path / "outputs" / "c", 3, state="done", coverage=0.75)
    by_option = cli("runs", "--state", "done", "--sort=coverage")
    by_word = cli("runs", "state=done", "sort=coverage")
    assert by_option.code == 0 and by_option.out == by_word.out
    assert [line.split()[0] for line in by_option.out.splitlines() if line.startswith(" outputs/")] == \
        ["outputs/c", "outputs/a"]


@pytest.mark.parametrize(("words", "said"), [
    (("compare", "x", "--markin", "swept"), "--marking"),
    (("compare", "x", "--marking", "swepd"), "Did you mean swept?"),
    (("runs", "--state=don"), "Did you mean done?"),
    (("coverage", "x", "--denominator", "flor"), "Did you mean floor?"),
])
def test_a_mistyped_one_is_answered_with_the_nearest(cli: Cli, words: tuple[str, ...], said: str) -> None:
    answer = cli(*words)
    assert answer.code == 2 and said in answer.error and "Traceback" not in answer.error
