"""Words of a command line that takes folders and a few settings of its own, as in: coverage RUN marking=swept."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from pathlib import Path

from curionav_cli.errors import ConfigError
from curionav_cli.files import place

Choices = Mapping[str, Sequence[str]]  # setting -> its values; none: anything


def sorted_out(command: str, words: Sequence[str], choices: Choices) -> tuple[list[Path], dict[str, str]]:
    """Folders and settings. Raises ConfigError for a setting or a value that the command does not have."""
    settings = [word for word in words if "=" in word and not place(word).exists()]
    folders = [place(word) for word in words if word not in settings]
    return folders, dict(choice(command, word, choices) for word in settings)


def choice(command: str, word: str, choices: Choices) -> tuple[str, str]:
    """'marking=swept' -> its key and value."""
    key, _, value = word.partition("=")
    if key not in choices:
        raise ConfigError(f"{command} has no setting {key}. It has: {', '.join(choices)}.")
    if not value:
        raise ConfigError(f"{key}= is empty. Give it a value, or leave it out.")
    return key, one_of(key, value, choices[key]) if choices[key] else value


def one_of(key: str, value: str, values: Sequence[str]) -> str:
    """`value`, if it is one of them."""
    if value not in values:
        near = difflib.get_close_matches(value, values, 1)
        raise ConfigError(f"{key}: {value!r} is not one of {', '.join(values)}."
                          + (f" Did you mean {near[0]}?" if near else ""))
    return value
