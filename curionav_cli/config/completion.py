"""Completion for the shell: options of a group, keys of the settings, values of an enumeration."""

from __future__ import annotations

import os
from pathlib import Path

from hydra.errors import HydraException

from curionav_cli.config import catalogue
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.sources import opened
from curionav_cli.config.suggestions import choices
from curionav_cli.errors import UserError


def completions(command: str, words: list[str], word: str, config_dir: Path | None = None) -> list[str]:
    """Whole words that begin with `word`; `words` are the settings typed before it."""
    try:
        with opened(command, config_dir) as hydra:
            groups = catalogue.groups(hydra)
            settings = OverrideErrors(hydra, words).base(words)
    except (UserError, HydraException):
        return []
    key, equals, value = word.partition("=")
    if equals:
        head, comma, last = value.rpartition(",")
        options = groups.get(key) or choices(settings, key)
        return [f"{key}={head}{comma}{option}" for option in options if option.startswith(last)]
    names = [f"{name}=" for name in groups]
    names += [f"{name}=" for name, _ in catalogue.flat(settings) if name not in groups]
    return [name for name in names if name.startswith(word)]


def shell_words() -> tuple[list[str], str] | None:
    """The words of bash, which cuts them at '=' (env=sm is env, =, sm), joined again, and the part of the last one that
    bash replaces; None under other shells, which pass whole words."""
    line = os.environ.get("COMP_WORDS")
    if line is None:
        return None
    cut = line.split("\n")[: int(os.environ.get("COMP_CWORD", "0")) + 1]
    words: list[str] = []
    glued = False
    for piece in cut:
        if words and (piece == "=" or glued):
            words[-1] += piece
        else:
            words.append(piece)
        glued = piece == "="
    return words, "" if cut[-1] == "=" else cut[-1]
