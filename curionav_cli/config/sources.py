"""Where settings come from: conf/ of this package, the directories of a user, and the schema.

Hydra's search path, in order of rank: --config-dir, CURIONAV_CONFIG_PATH (directories separated as
in PATH), conf/. The schema (schema.py) is registered under the hidden group `schema/`.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import fields, is_dataclass
from functools import cache
from pathlib import Path
from typing import get_type_hints

import yaml
from hydra import initialize_config_dir
from hydra._internal.hydra import Hydra
from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.config_store import ConfigStore
from hydra.core.global_hydra import GlobalHydra
from hydra.core.plugins import Plugins
from hydra.plugins.search_path_plugin import SearchPathPlugin
from omegaconf import DictConfig, OmegaConf

from curionav_cli.agents.registry import AGENTS
from curionav_cli.config import plugins, schema, search
from curionav_cli.config.loader import Loader
from curionav_cli.config.whole_numbers import take_any_spelling
from curionav_cli.errors import ConfigError
from curionav_cli.files import conf_dir, place
from curionav_cli.live import settings as live_settings
from curionav_cli.robot import settings as robot_settings
from curionav_cli.safe_yaml import refuse_bomb
from curionav_cli.world import settings as world_settings

MAIN = "config"  # conf/config.yaml
COMMAND_DEFAULTS = {"dock": ("agent=bounce", "robot=turtlebot2i")}  # that differ from those of conf/

ROBOTS = {
    "ideal": robot_settings.Robot,
    "turtlebot2i": robot_settings.Turtlebot,
    "turtlebot2i_plus": robot_settings.Turtlebot,
    "rosbridge": live_settings.Rosbridge,
}


@contextmanager
def opened(command: str, *config_dirs: Path | None) -> Iterator[Hydra]:
    """Open Hydra on our search path; `command` names the job and its log.

    Restores the handlers of the root logger, which Hydra replaces by a file in the run folder.
    Raises ConfigError where a directory of the user does not exist.
    """
    register(user_directories(config_dirs))
    root = logging.getLogger()
    handlers, level = list(root.handlers), root.level
    try:
        with initialize_config_dir(str(conf_dir()), job_name=command, version_base="1.3"):
            hydra = GlobalHydra.instance().hydra
            assert hydra is not None
            hydra.config_loader = Loader(hydra.config_loader.get_search_path())
            yield hydra
    finally:
        for handler in set(root.handlers) - set(handlers):
            handler.close()
        root.handlers[:] = handlers
        root.setLevel(level)


def user_directories(config_dirs: Iterable[Path | None]) -> list[Path]:
    """The user's own config directories, the first one ranks highest. Raises ConfigError for one that is not there."""
    named = [("--config-dir", place(path)) for path in config_dirs if path]
    for part in os.environ.get("CURIONAV_CONFIG_PATH", "").split(os.pathsep):
        if part:
            named.append(("CURIONAV_CONFIG_PATH", place(part)))
    for origin, path in named:
        if not path.is_dir():
            raise ConfigError(f"{origin}: there is no directory {path}. Name one that exists.")
    for file in (file for _, path in named for file in path.rglob("*.yaml")):
        try:
            refuse_bomb(file.read_text(encoding="utf-8"))
        except yaml.YAMLError:
            continue  # answered by Hydra, if the file is chosen
        except (OSError, ValueError) as error:
            raise ConfigError(f"{file} cannot be used: {error}.") from error
    return list(dict.fromkeys(path.resolve() for _, path in named))


class UserDirectories(SearchPathPlugin):
    """Put the user's directories before conf/; a launcher's workers get the same search path."""

    paths: tuple[Path, ...] = ()

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        for path in reversed(self.paths):
            search_path.prepend(provider="user", path=f"file://{path}")


def register(directories: list[Path]) -> None:
    """Register the schema and the user's directories with Hydra; may be repeated."""
    UserDirectories.paths = tuple(directories)
    plugins.broken()
    search.defaults()
    Plugins.instance().register(UserDirectories)
    register_schema("schema", MAIN, schema.Config, "_global_")
    register_schema("schema", "env", world_settings.Env, "env")
    register_schema("schema", "live", world_settings.Live, "env")
    register_schema("schema", "scan", world_settings.Scan, "env")
    for name, agent in AGENTS.items():
        register_schema("schema/agent", name, agent.settings, "agent")
    for name, node in ROBOTS.items():
        register_schema("schema/robot", name, node, "robot")


@cache
def register_schema(group: str, name: str, node: type, package: str) -> None:
    """Register a dataclass with Hydra, once a process."""
    ConfigStore.instance().store(group=group, name=name, node=converted(node), package=package)


def writable(node: type) -> DictConfig:
    """A frozen dataclass as a config node that YAML and the command line may change."""
    return deepcopy(converted(node))


@cache
def converted(node: type) -> DictConfig:
    """The one config node of a dataclass, to be copied."""
    config = OmegaConf.structured(node)
    OmegaConf.set_readonly(config, None)
    hints = get_type_hints(node)
    for field in fields(node):
        if is_dataclass(hints[field.name]):
            config[field.name] = converted(hints[field.name])
        take_any_spelling(config._get_node(field.name))
    return config
