"""Paths as a user types them: with ~, and with characters that Hydra's grammar reserves."""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

from hydra._internal.hydra import Hydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException

from curionav_cli.config import catalogue
from curionav_cli.config.schema import Config
from curionav_cli.places import place

SETTINGS = ("env.map", "env.mesh", "env.overlay", "env.floor", "data", "init", "storage", "hydra.run.dir",
            "hydra.sweep.dir")


def as_typed(hydra: Hydra, word: str) -> str:
    """The word for Hydra, quoted where Hydra would misread it: a path, or an option of a group such as env=büro."""
    key, _, text = word.partition("=")
    key = of_group(hydra, key)
    word = f"{key}={text}" if "=" in word else word
    return f"{key}={quoted(text)}" if misread(hydra, word, key.lstrip("+"), text) else word


def of_group(hydra: Hydra, key: str) -> str:
    """The key as Hydra has it: a group within a group may be written as a setting, robot.profile as robot/profile."""
    within = key.replace(".", "/")
    return within if within != key and catalogue.options_of(hydra, within) else key


def misread(hydra: Hydra, word: str, key: str, text: str) -> bool:
    """Whether Hydra would take a path or a name for a list, a number or a formula."""
    try:
        override = OverridesParser.create(config_loader=hydra.config_loader).parse_overrides([word])[0]
    except HydraException:
        return key in SETTINGS or text in catalogue.options_of(hydra, key)
    if key not in SETTINGS or place(text).exists():
        return key in SETTINGS
    if override.is_sweep_override():
        return key.startswith("hydra.")  # which is not swept over
    return not isinstance(override.value(), str | None)


def quoted(text: str) -> str:
    """`text` as a quoted string of Hydra's grammar, in which a backslash escapes only a quote."""
    escaped = re.sub(r"(\\*)('|$)", lambda found: found[1] * 2 + found[2].replace("'", "\\'"), text)
    return f"'{escaped}'"


def as_text(word: str) -> str:
    """What to type at a prompt so that the value is taken as text; in double quotes where they suffice."""
    key, _, text = word.partition("=")
    whole = f"{key or 'key'}={quoted(text)}"
    return shlex.quote(whole) if re.search(r'["$`\\!]', whole) else f'"{whole}"'


def rooted(settings: Config, start: Path) -> Config:
    """The settings with absolute paths, relative ones taken from the folder `start`, so that any folder can resume."""
    def absolute(path: str | None) -> str | None:
        return str((start / place(path)).resolve()) if path else None
    files: dict[str, Any] = {name: absolute(getattr(settings.env, name)) for name in ("map", "overlay", "floor", "mesh")
             if hasattr(settings.env, name)}
    env = replace(settings.env, **files)
    return replace(settings, env=env, data=absolute(settings.data), init=absolute(settings.init))
