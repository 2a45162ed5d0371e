"""Arguments of commands that read folders and have a few settings of their own, as in: coverage RUN marking=swept."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from curionav_cli.errors import ConfigError
from curionav_cli.places import place

Choices = Mapping[str, Sequence[str]]  # setting -> its values; none: anything


def sorted_out(command: str, words: Sequence[str], choices: Choices) -> tuple[list[Path], dict[str, str]]:
    """Split `words` into folders and settings. Raises ConfigError for what the command does not have."""
    settings = [word for word in words if "=" in word and not place(word).exists()]
    folders = [place(word) for word in words if word not in settings]
    return folders, dict(choice(command, word, choices) for word in settings)


def choice(command: str, word: str, choices: Choices) -> tuple[str, str]:
    """Key and value of 'marking=swept'. Raises ConfigError for one that the command does not have."""
    key, _, value = word.partition("=")
    if key not in choices:
        raise ConfigError(f"{command} has no setting {key}. It has: {', '.join(choices)}.")
    if not value:
        raise ConfigError(f"{key}= is empty. Give it a value, or leave it out.")
    return key, one_of(key, value, choices[key]) if choices[key] else value


def one_of(key: str, value: str, values: Sequence[str]) -> str:
    """`value`, if it is one of `values`. Raises ConfigError, with the nearest, if not."""
    if not value:
        raise ConfigError(f"{key}: name one of {', '.join(values)}.")
    if value not in values:
        near = difflib.get_close_matches(value, values, 1)
        raise ConfigError(f"{key}: {value!r} is not one of {', '.join(values)}."
                          + (f" Did you mean {near[0]}?" if near else ""))
    return value


def episode_numbers(key: str, words: str, count: int, run: Path) -> list[int]:
    """The episodes of '0,5,9' or 'last', sorted, of a run that has `count`.

    Raises ConfigError for anything else, and for episodes that the run does not have.
    """
    if not re.fullmatch(r"(\d+|last)(,(\d+|last))*", words):
        raise ConfigError(f"{key}: {words!r} is not a list of episodes. Write it as {key}=0,5,last")
    found = sorted({count - 1 if word == "last" else int(word) for word in words.split(",")})
    if found[-1] >= count:
        raise ConfigError(f"{run} has no episode {found[-1]}. It has 0 to {count - 1}.")
    return found
