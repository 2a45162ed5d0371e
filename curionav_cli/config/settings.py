"""Turn a composed configuration into the frozen dataclasses of schema.py, and into YAML in a run folder and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import yaml
from omegaconf import DictConfig, OmegaConf, flag_override
from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException

from curionav_cli.agents.registry import AGENTS
from curionav_cli.config.loader import copies
from curionav_cli.config.paths import rooted
from curionav_cli.config.schema import Config, Loop
from curionav_cli.config.schema_source import ROBOTS, writable
from curionav_cli.config.sources import MAIN, conf_dir
from curionav_cli.config.suggestions import in_words, type_of
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.safe_yaml import refuse_bomb
from curionav_cli.storage.older_runs import RENAMED, held
from curionav_cli.world.settings import Live, Scan


def as_settings(config: DictConfig, start: Path | None = None) -> Config:
    """The frozen Config of a composed configuration; relative paths are taken from `start`, or the working directory.

    Raises ConfigError for a missing value or one out of range.
    """
    own = copies(config)()
    with flag_override(own, ["struct", "readonly"], False):
        own.pop("hydra", None)
    try:
        settings = OmegaConf.to_object(own)
    except MissingMandatoryValue as error:
        key = missing_key(own, error)
        raise ConfigError(f"{key} has no value. Give it one: {key}=...") from error
    except OmegaConfBaseException as error:
        raise ConfigError(f"{error.full_key or 'settings'}: {str(error).splitlines()[0]}") from error
    except ValueError as error:  # of a __post_init__, which names its key
        raise ConfigError(str(error)) from error
    assert isinstance(settings, Config)
    return rooted(settings, start or Path.cwd())


def missing_key(config: DictConfig, error: MissingMandatoryValue) -> str:
    """The key of the first missing value; a group that was set to null is missing as a whole."""
    missing = sorted(OmegaConf.missing_keys(config))
    return missing[0] if missing else str(error.full_key)


def settings_yaml(settings: Config) -> str:
    """The YAML of a run folder's config.yaml, which read_settings reads."""
    return OmegaConf.to_yaml(OmegaConf.create(asdict(settings)))


def plain_settings(settings: Config) -> dict[str, Any]:
    """What reading settings_yaml gives: dictionaries, lists, strings and numbers."""
    plain = OmegaConf.to_container(OmegaConf.create(asdict(settings)), enum_to_str=True)
    assert isinstance(plain, dict)
    return {str(key): value for key, value in plain.items()}


def read_settings(path: Path, changes: Sequence[str] = ()) -> Config:
    """Read the settings that a run began with, and apply `changes`, such as ["loop.episodes=20"].

    Raises RunFolderError where they cannot be read, ConfigError for a wrong value among the changes.
    """
    try:
        text = path.read_text()
        refuse_bomb(text)
        recorded = OmegaConf.create(yaml.safe_load(text))
        for old in RENAMED.keys() & recorded.keys():
            recorded[RENAMED[old]] = recorded.pop(old)
        node = writable(Config)
        node.merge_with(newer())
        agent = AGENTS[recorded.agent.name].settings
        node["agent"] = writable(agent)
        node["robot"] = writable(ROBOTS[recorded.robot.name])
        for key, kind in (("floor", Live), ("mesh", Scan)):
            if key in recorded.env:
                node["env"] = writable(kind)
        if "homing" in recorded.robot:
            node.merge_with({"robot": {"docking": by_light()}})
        kinds = {"agent": agent, "loop": Loop}
        older = {key: held(key, [field.name for field in fields(kind)]) for key, kind in kinds.items()}
        node.merge_with(older, recorded)
        settings = as_settings(node)
    except OSError as error:
        raise RunFolderError(f"{path} cannot be read ({error.strerror}). Name the folder of a run.") from error
    except (OmegaConfBaseException, ConfigError, LookupError, AttributeError, ArithmeticError, RecursionError,
            TypeError, ValueError, yaml.YAMLError) as error:
        line = next(iter(str(error).splitlines()), type(error).__name__)
        raise RunFolderError(f"{path} does not hold the settings of a run: {line}") from error
    return changed(node, changes) if changes else settings


def newer() -> dict[str, Any]:
    """Today's values of settings that an older run may not have."""
    now = yaml.safe_load((conf_dir() / f"{MAIN}.yaml").read_text())
    return {key: now[key] for key in ("learner", "storage", "remote")}


def by_light() -> dict[str, Any]:
    """Today's settings of a real robot that docks by light, which an older run lacks."""
    folder = conf_dir() / "robot"
    now = yaml.safe_load((folder / "rosbridge.yaml").read_text())["docking"]
    return {**now, "approach": yaml.safe_load((folder / "approach" / "kobuki.yaml").read_text())}


def changed(config: DictConfig, changes: Sequence[str]) -> Config:
    """The settings of `config` with `changes`. Raises ConfigError for a wrong value."""
    for change in changes:
        key, _, value = change.partition("=")
        try:
            kind = type_of(config, key)
            OmegaConf.update(config, key, yaml.safe_load(value) if kind is Any else value)
        except OmegaConfBaseException as error:
            raise ConfigError(f"{key}: {value!r} is not {in_words(type_of(config, key))}.") from error
    return as_settings(config)
