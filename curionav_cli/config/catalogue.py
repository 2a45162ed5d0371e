"""What may be set: groups with their options, keys with their values; for help, completion and suggestions."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Any, cast

from hydra._internal.hydra import Hydra
from hydra.core.object_type import ObjectType
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from curionav_cli.agents.registry import AGENTS, unread
from curionav_cli.config.sources import MAIN

HIDDEN = ("hydra", "schema")


def groups(hydra: Hydra) -> dict[str, list[str]]:
    """The groups (env, agent, robot, scale, ...), each with its options."""
    loader = hydra.config_loader
    names = (name for name in loader.list_groups("") if name not in HIDDEN)
    return {name: options for name in sorted(names) if (options := options_of(hydra, name))}


def options_of(hydra: Hydra, group: str) -> list[str]:
    """The options of a group, sorted."""
    repository = cast(Any, hydra.config_loader).repository  # the loader's own method first copies all configurations
    return sorted(repository.get_group_options(group, ObjectType.CONFIG))


def note(hydra: Hydra, group: str, option: str) -> str:
    """One line about an option: the first comment of its file, else the first line of the agent's schema."""
    for source in hydra.config_loader.get_search_path().get_path():
        path = Path(str(source.path).removeprefix("file://")) / group / f"{option}.yaml"
        if path.is_file():
            lines = path.read_text(encoding="utf-8").splitlines()
            comments = [line.lstrip("# ") for line in lines if line.startswith("#") and "@package" not in line]
            schema = AGENTS[option].settings if option in AGENTS else None
            return comments[0] if comments else (getattr(schema, "__doc__", "") or "").partition("\n")[0]
    return ""


def settings(config: DictConfig) -> dict[str, Any]:
    """Flat key -> value of a composed configuration."""
    return dict(flat(config))


def choices(config: DictConfig) -> dict[str, list[str]]:
    """The settings that are an enumeration -> its members: agent.view -> [pano, ego]."""
    return {key: list(type(value).__members__) for key, value in flat(config, words=False) if isinstance(value, Enum)}


def composed(hydra: Hydra, overrides: list[str]) -> DictConfig:
    """What these overrides compose to; the defaults where they cannot be composed."""
    try:
        return hydra.compose_config(MAIN, overrides, RunMode.RUN)
    except HydraException:
        return hydra.compose_config(MAIN, [], RunMode.RUN)


def flat(config: DictConfig, words: bool = True) -> Iterator[tuple[str, Any]]:
    """Yield keys and values as YAML shows them: ('loop.steps', 500), ...; lists and empty dictionaries are values.

    What the chosen agent does not read is left out. words: members of an enumeration as their names.
    """
    container = OmegaConf.to_container(config, enum_to_str=words)
    assert isinstance(container, dict)
    hidden = hidden_keys(config)
    shown = leaves({key: value for key, value in container.items() if key not in HIDDEN}, "")
    yield from ((key, value) for key, value in shown if key not in hidden)


def hidden_keys(config: DictConfig) -> set[str]:
    """The settings that the chosen agent does not read: agent.entropy, ..."""
    return {f"agent.{name}" for name in unread(OmegaConf.get_type(config, "agent"))} if "agent" in config else set()


def hydra_keys(config: DictConfig) -> list[str]:
    """Every key of Hydra's own part: hydra.sweeper.n_trials, ..."""
    container = OmegaConf.to_container(config.hydra)
    assert isinstance(container, dict)
    return [key for key, _ in leaves(container, "hydra.")]


def leaves(container: dict[Any, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for key, value in container.items():
        if isinstance(value, dict) and value:
            yield from leaves(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
