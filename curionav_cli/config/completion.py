"""Completion for the shell: options of a group, keys of the settings, values of an enumeration."""

from __future__ import annotations

import os
import re
from pathlib import Path

from hydra.errors import HydraException
from omegaconf import DictConfig

from curionav_cli.config import catalogue
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.sources import opened
from curionav_cli.config.suggestions import choices
from curionav_cli.errors import UserError

WORD = re.compile(r"[\w.-]+")


def completions(command: str, words: list[str], word: str, config_dir: Path | None = None) -> list[str]:
    """Whole words that begin with `word`; `words` are those typed before it. In a sweep over agents or robots only
    settings that each of them has.

    The only key that fits comes with its values, because a shell would end a single word with a space.
    """
    typed = [one for one in words if "=" in one]
    try:
        with opened(command, config_dir) as hydra:
            groups = catalogue.groups(hydra)
            settings = [OverrideErrors(hydra, job).base(job) for job in jobs(typed, groups)]
    except (UserError, HydraException):
        return []
    key, equals, value = word.partition("=")
    if equals:
        head, comma, last = value.rpartition(",")
        options = [option for option in values(key, groups, settings) if option not in head.split(",")]
        return [f"{key}={head}{comma}{option}" for option in options if option.startswith(last)]
    names = [*groups, *(name for name in in_all([keys(one) for one in settings]) if name not in groups)]
    found = [name for name in names if name.startswith(word)]
    only = values(found[0], groups, settings) if len(found) == 1 else []
    return [f"{name}=" for name in found] + [f"{found[0]}={option}" for option in only]


def values(key: str, groups: dict[str, list[str]], settings: list[DictConfig]) -> list[str]:
    """What a key can be: options of a group, members of an enumeration, else the value that it has, if that is one
    word for every shell."""
    options = groups.get(key) or in_all([choices(one, key) for one in settings])
    if options:
        return options
    held = dict(catalogue.flat(settings[0])).get(key, "")
    word = "null" if held is None else str(held)
    return [word] if WORD.fullmatch(word) else []


def jobs(words: list[str], groups: dict[str, list[str]]) -> list[list[str]]:
    """Of a sweep over groups (agent=mapper,bounce) as many command lines of a single run as have each option once."""
    parts = [word.partition("=") for word in words]
    options = [value.split(",") if key in groups else [value] for key, _, value in parts]
    return [[f"{key}={one[number % len(one)]}" for (key, _, _), one in zip(parts, options, strict=True)]
            for number in range(max(map(len, options), default=1))]


def keys(settings: DictConfig) -> list[str]:
    return [key for key, _ in catalogue.flat(settings)]


def in_all(found: list[list[str]]) -> list[str]:
    """The words that stand in each of these lists, in the order of the first."""
    return [word for word in found[0] if all(word in other for other in found)]


def group_names(word: str, config_dir: Path | None = None) -> list[str]:
    """The groups of settings that begin with `word`."""
    try:
        with opened("explore", config_dir) as hydra:
            return [name for name in catalogue.groups(hydra) if name.startswith(word)]
    except (UserError, HydraException):
        return []


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
