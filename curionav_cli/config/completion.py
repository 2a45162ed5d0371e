"""Completion for the shell: options of a group, keys of the settings, values of an enumeration."""

from __future__ import annotations

import os
from pathlib import Path

from hydra.errors import HydraException
from omegaconf import DictConfig

from curionav_cli.config import catalogue
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.sources import opened
from curionav_cli.config.suggestions import choices
from curionav_cli.errors import UserError


def completions(command: str, words: list[str], word: str, config_dir: Path | None = None) -> list[str]:
    """Whole words that begin with `word`; `words` are those typed before it. In a sweep over agents or robots only
    settings that each of them has."""
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
        options = groups.get(key) or in_all([choices(one, key) for one in settings])
        return [f"{key}={head}{comma}{option}" for option in options
                if option.startswith(last) and option not in head.split(",")]
    names = [f"{name}=" for name in groups]
    names += [f"{name}=" for name in in_all([keys(one) for one in settings]) if name not in groups]
    return [name for name in names if name.startswith(word)]


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
