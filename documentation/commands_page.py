"""docs/reference/commands.md: every command with its arguments and options, as --help has them."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Any

import typer.main

from curionav_cli import app as application
from curionav_cli.commands.settings_help import SettingsCommand
from documentation.markdown import GENERATED, code, table

ABOUT = """# Commands

`curionav COMMAND --help` shows the same. `curionav --version` prints the version; `--install-completion` completes
commands, options and settings in bash, zsh and fish.

A command exits with 0 when it is done, 1 when the run began and could not go on (or, of `doctor` and `robot check`,
when something is to be mended), 2 for a wrong setting, file or folder, 130 after Ctrl-C, 141 when its output was closed
(`| head`), 143 after SIGTERM. What is wrong stands in one to four lines on stderr
([troubleshooting](../troubleshooting.md)).
"""


def page() -> str:
    """The whole page."""
    lines = [GENERATED.format("the command line"), "", ABOUT]
    for name, command in sorted(commands(typer.main.get_command(application.app), "")):
        lines += [f"## curionav {name}", "", command.help or "", "", *usage(name, command), *options(name, command), ""]
    return "\n".join(lines).rstrip() + "\n"


def commands(group: Any, parent: str) -> Iterator[tuple[str, Any]]:
    """Every command with its words: ('explore', ...), ('robot check', ...)."""
    for name, command in group.commands.items():
        if hasattr(command, "commands"):
            yield from commands(command, f"{parent}{name} ")
        else:
            yield f"{parent}{name}", command


def usage(name: str, command: Any) -> list[str]:
    """The line to type, in a block, and where its settings stand."""
    arguments = [parameter for parameter in command.params if parameter.param_type_name == "argument"]
    words = [f"{one.metavar}{'...' if one.nargs == -1 else ''}" for one in arguments]
    shown = " ".join(word if one.required else f"[{word}]" for one, word in zip(arguments, words, strict=True))
    lines = ["```", f"curionav {name} [OPTIONS] {shown}".rstrip(), "```", ""]
    if isinstance(command, SettingsCommand):
        lines += ["Its settings: [settings](settings.md).", ""]
    return lines


def options(name: str, command: Any) -> list[str]:
    """The table of arguments and options."""
    rows = [(code(spelled(one)), takes(name, one), one.help or "") for one in command.params if not one.hidden]
    return table(("", "takes", ""), [*rows, ("`-h`, `--help`", "", "Show this message and exit.")])


def spelled(parameter: Any) -> str:
    """Both spellings of an option, or an argument's name; code() puts the ticks around all of it."""
    return "`, `".join(parameter.opts) if parameter.param_type_name == "option" else parameter.metavar


def takes(name: str, parameter: Any) -> str:
    """The values that an option takes."""
    kind = parameter.type_descriptor.annotation
    members = [one.value for one in kind] if isinstance(kind, type) and issubclass(kind, Enum) else []
    choices = members or own_choices(name).get(str(parameter.name))
    if choices:
        return ", ".join(map(code, choices))
    return {str: "text", Path: "a path"}.get(kind, "")


def own_choices(name: str) -> dict[str, Any]:
    """The values of the options KEY=VALUE of a command, where it lists them."""
    module = importlib.import_module(f"curionav_cli.commands.{name.replace('list', 'listing').partition(' ')[0]}")
    return getattr(module, "CHOICES", {})
