"""What a setting is, from the schema: its type, its default, its range and its meaning."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from fnmatch import fnmatchcase
from functools import cache
from itertools import zip_longest
from pathlib import Path
from types import NoneType
from typing import Any, get_args

import yaml
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf, flag_override

from curionav_cli.bounds import Range, noted
from curionav_cli.commands.settings_help import brief
from curionav_cli.config.catalogue import HIDDEN, hidden_keys, leaves
from curionav_cli.config.settings import as_settings
from curionav_cli.config.sources import MAIN, opened
from curionav_cli.config.suggestions import in_words, owner_of, type_of
from curionav_cli.places import conf_dir

MEANINGS = Path(__file__).with_name("meanings.yaml")
NAMES = ("env.name", "agent.name", "robot.name")  # set by choosing an option of the group
DEFAULTS = {"env": "small_room", "agent": "lbs_dreamer", "robot": "ideal"}
PAPER = "scale=paper"


@dataclass(frozen=True)
class Setting:
    """One row. kind: its type in words; null: whether it may be null; range: least and most, None without."""

    key: str
    kind: str
    default: Any
    range: Range | None
    listed: bool  # whether the range is that of each of a list's items

    @property
    def limits(self) -> str:
        if self.range is None:
            return ""
        return ("each " if self.listed else "") + " to ".join(f"{bound:.10g}" for bound in self.range)


def options(group: str) -> list[str]:
    """The options of a group as they are typed, env=..., the default first."""
    names = sorted(path.stem for path in (conf_dir() / group).glob("*.yaml"))
    first = DEFAULTS.get(group)
    return [f"{group}={name}" for name in sorted(names, key=lambda name: (name != first, name))]


def scaled() -> list[str]:
    """The agents whose numbers depend on the scale."""
    return [f"agent={path.name}" for path in sorted((conf_dir() / "scale").iterdir()) if path.is_dir()]


@cache
def compositions() -> list[tuple[tuple[str, ...], dict[str, Setting]]]:
    """Words and all settings of what they compose to; every option of env, agent and robot is among the words.

    Robots stand alone: the profile of a real one sets values of env.
    """
    first, *robots = options("robot")
    rows = [tuple(word for word in (*row, first) if word) for row in zip_longest(options("env"), options("agent"))]
    rows += [(robot,) for robot in robots]
    with opened("explore") as hydra:
        return [(words, composed(hydra.compose_config(MAIN, list(words), RunMode.RUN)))
                for words in [*rows, *((agent, PAPER) for agent in scaled())]]


def composed(config: DictConfig) -> dict[str, Setting]:
    """Every setting of a composed configuration, by its key."""
    ranges, hidden = checked(config), hidden_keys(config)
    return {key: Setting(key, kind(config, key, value), value, range_of(key, ranges), isinstance(value, list))
            for key, value in flat(config) if key not in hidden}


def settings(word: str, paper: bool = False) -> dict[str, Setting]:
    """The settings of an option's group: 'env=map' -> env.map, ..."""
    part = word.partition("=")[0] + "."
    found = next(found for words, found in compositions() if word in words and (PAPER in words) == paper)
    return {key: one for key, one in found.items() if key.startswith(part)}


def common() -> dict[str, Setting]:
    """The settings that belong to no option of env, agent or robot."""
    _, found = compositions()[0]
    return {key: one for key, one in found.items() if key.partition(".")[0] not in DEFAULTS}


def flat(config: DictConfig, parent: str = "") -> Iterator[tuple[str, Any]]:
    """Yield keys and values as YAML shows them; a dictionary of the schema is one value."""
    for name in (name for name in config if str(name) not in HIDDEN and f"{parent}{name}" not in NAMES):
        key = f"{parent}{name}"
        node = None if OmegaConf.is_missing(config, name) else config[name]
        if isinstance(node, DictConfig) and OmegaConf.get_type(node) is not dict:
            yield from flat(node, f"{key}.")
        else:
            yield key, shown(node)


def shown(node: Any) -> Any:
    """A value without OmegaConf's containers and enumerations."""
    if OmegaConf.is_config(node):
        return OmegaConf.to_container(node, enum_to_str=True)
    return node.name if isinstance(node, Enum) else node


def kind(config: DictConfig, key: str, value: Any) -> str:
    """The type of a setting, in words."""
    hint = type_of(config, key)
    may_be_null = NoneType in get_args(hint)
    return (in_words(hint) or in_words(type(value)) or "any") + (", or null" if may_be_null else "")


def checked(config: DictConfig) -> dict[str, Range]:
    """The ranges that the schema checks, with a number in the place of each null."""
    filled = OmegaConf.create(config)
    with flag_override(filled, ["struct", "readonly"], False), noted() as ranges:
        as_settings(config)
        for key, value in flat(config):
            if value is None and owner_of(config, key.rpartition(".")[0]) and {int, float} & set(
                    get_args(type_of(config, key))):
                OmegaConf.update(filled, key, 1)
        as_settings(filled)
    return ranges


def range_of(key: str, ranges: dict[str, Range]) -> Range | None:
    """The range of a setting, or the one that all values of its dictionary have.

    The schema names a topic of a profile by its own name in brackets: 'robot.profile (/image).crop'.
    """
    ranges = {re.sub(r" \(.*\)", "", name): span for name, span in ranges.items()}
    key = re.sub(r"\.\w+\.crop$", ".crop", key)
    inner = {span for name, span in ranges.items() if name.startswith(f"{key}.")}
    return ranges.get(key) or (inner.pop() if len(inner) == 1 else None)


@cache
def meanings() -> dict[str, str]:
    """Key or pattern -> what a setting means, from meanings.yaml."""
    return dict(leaves(yaml.safe_load(MEANINGS.read_text(encoding="utf-8")), ""))


def meaning(key: str) -> str:
    """What a setting means. Raises LookupError where meanings.yaml has no line for it."""
    found = meanings().get(key) or next((text for name, text in meanings().items() if fnmatchcase(key, name)), None)
    if not found:
        raise LookupError(f"{key} has no meaning: give it a line in {MEANINGS.name}, then: make docs")
    return found


def value(setting: Setting) -> str:
    """The default as it is typed; of the lists of a scene only how long they are."""
    default = setting.default
    if isinstance(default, list) and not any(isinstance(item, dict) for item in default):
        return f"[{', '.join(map(typed, default))}]"
    if isinstance(default, dict):
        return f"{{{', '.join(f'{key}: {typed(item)}' for key, item in default.items())}}}"
    return brief(default) if isinstance(default, list) else typed(default)


def typed(default: Any) -> str:
    """A number, a word, true, false or null, as on the command line."""
    if isinstance(default, float):
        return f"{default:.10g}"
    return str(default) if isinstance(default, str) else yaml.safe_dump(default).split("\n")[0]
