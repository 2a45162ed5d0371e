"""Parts of an answer to a wrong override: near names, a group's options, what a type takes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import is_dataclass
from difflib import get_close_matches
from enum import Enum
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from curionav_cli.agents.registry import readers

NAMES = {
    int: "a whole number", float: "a number", bool: "true or false", str: "text",
    dict: "keys with values, {key: value}",
}


def closest(word: str, known: Iterable[str]) -> list[str]:
    """Full keys near `word`; else those whose last part is it, has it as a word (lr: model_lr), or is near it."""
    leaves: dict[str, list[str]] = {}
    for key in known:
        leaves.setdefault(key.rpartition(".")[2], []).append(key)
    keys = [key for same in leaves.values() for key in same]
    parent, _, leaf = word.rpartition(".")
    near = [] if leaf in leaves and not parent else get_close_matches(word, keys, n=2, cutoff=0.75)
    if near:
        return near
    names = [leaf] if leaf in leaves else [name for name in leaves if leaf in name.split("_")]
    names = names or get_close_matches(leaf, leaves, n=1, cutoff=0.7)
    return [key for name in names for key in leaves[name]]


def near_options(choice: str, options: list[str]) -> list[str]:
    """Options that are spelled nearly so, else those that begin with it (lbs: lbs_dreamer); at most two."""
    longer = [name for name in options if choice and name.startswith(choice)]
    return get_close_matches(choice, options, n=2) or longer[:2]


def of_agents(key: str) -> str:
    """A sentence that names the agents which read this setting; nothing where none does."""
    group, _, name = key.partition(".")
    owners = readers(name)
    return f" It is a setting of agent={', agent='.join(owners)}." if group == "agent" and owners else ""


def did_you_mean(names: list[str]) -> str:
    return f" Did you mean {' or '.join(names)}?" if names else ""


def has(group: str, options: list[str]) -> str:
    """A further line that lists a group's options; nothing where there are none."""
    return f"\n{group} has: {', '.join(options)}." if options else ""


def type_of(config: DictConfig, key: str) -> Any:
    """The annotation of a key of the composed config; None for a key of a plain dictionary."""
    parent, _, leaf = key.rpartition(".")
    owner = owner_of(config, parent)
    return get_type_hints(owner).get(leaf) if is_dataclass(owner) else None


def choices(config: DictConfig, key: str) -> list[str]:
    """The values of a key that is true or false or an enumeration; [] for any other."""
    kind, value = type_of(config, key), OmegaConf.select(config, key)
    kind = type(value) if kind is Any and isinstance(value, Enum) else kind  # one of them, or a list
    if kind is bool:
        return ["false", "true"]
    return list(kind.__members__) if isinstance(kind, type) and issubclass(kind, Enum) else []


def in_words(kind: Any) -> str | None:
    """What a type takes, in words; None for a type without any."""
    if get_origin(kind) in (Union, UnionType):
        return in_words(next(each for each in get_args(kind) if each is not NoneType))
    if get_origin(kind) is list:
        each = in_words(get_args(kind)[0])
        return f"a list [...], each {each}" if each else "a list [...]"
    if isinstance(kind, type) and issubclass(kind, Enum):
        return f"one of {', '.join(kind.__members__)}"
    return NAMES.get(get_origin(kind) or kind)


def owner_of(config: DictConfig, parent: str) -> type | None:
    """The dataclass whose fields are the keys under `parent` ("" for the top); None if there is none."""
    node = OmegaConf.select(config, parent) if parent else config
    return OmegaConf.get_type(node) if isinstance(node, DictConfig) else None


def exists(config: DictConfig, key: str) -> bool:
    parent, _, leaf = key.rpartition(".")
    node = OmegaConf.select(config, parent) if parent else config
    return leaf in list(node.keys()) if isinstance(node, DictConfig) else isinstance(node, ListConfig)


def located(error: BaseException | None) -> OmegaConfBaseException | None:
    """The error of OmegaConf that Hydra wrapped: the outermost one, which has the full key."""
    while error is not None and not isinstance(error, OmegaConfBaseException):
        error = error.__cause__ or error.__context__
    return error


def first_line(text: str) -> str:
    return next((line.strip() for line in text.splitlines() if line.strip()), "")
