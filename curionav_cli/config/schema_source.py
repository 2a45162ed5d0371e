"""The schema as a source of configurations of Hydra, curionav://: the dataclasses of the settings.

A node is made when a composition asks for it. Hydra's own store wants all of them at the start of every command, and
copies them for each composition, which took a third of a second.
"""

from __future__ import annotations

import pickle
from dataclasses import fields, is_dataclass
from functools import cache
from typing import get_type_hints

from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from omegaconf import DictConfig, OmegaConf

from curionav_cli.agents.registry import AGENTS
from curionav_cli.config import schema
from curionav_cli.config.whole_numbers import take_any_spelling
from curionav_cli.live import settings as live_settings
from curionav_cli.robot import settings as robot_settings
from curionav_cli.world import settings as world_settings

ROBOTS = {
    "ideal": robot_settings.Robot,
    "turtlebot2i": robot_settings.Turtlebot,
    "turtlebot2i_plus": robot_settings.Turtlebot,
    "rosbridge": live_settings.Rosbridge,
}


class Schema(ConfigSource):
    """Finds `schema/<group>/<name>`; the hidden group `schema` is all there is."""

    @staticmethod
    def scheme() -> str:
        return "curionav"

    def load_config(self, config_path: str) -> ConfigResult:
        found = nodes().get(plain(config_path))
        if found is None:
            raise ConfigLoadError(f"The schema has no {config_path}.")
        node, package = found
        return ConfigResult(self.provider, f"{self.scheme()}://", writable(node), {"package": package})

    def is_group(self, config_path: str) -> bool:
        return bool(below(config_path))

    def is_config(self, config_path: str) -> bool:
        return plain(config_path) in nodes()

    def available(self) -> bool:
        return True

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        found: list[str] = []
        for name in below(config_path):
            self._list_add_result(found, f"{plain(config_path)}/{name}", name, results_filter)
        return sorted(set(found))


def nodes() -> dict[str, tuple[type, str]]:
    """Name of a configuration -> its dataclass, and the package that it describes."""
    found: dict[str, tuple[type, str]] = {
        "schema/config": (schema.Config, "_global_"), "schema/env": (world_settings.Env, "env"),
        "schema/live": (world_settings.Live, "env"), "schema/scan": (world_settings.Scan, "env")}
    found |= {f"schema/agent/{name}": (agent.settings, "agent") for name, agent in AGENTS.items()}
    return found | {f"schema/robot/{name}": (node, "robot") for name, node in ROBOTS.items()}


def plain(path: str) -> str:
    """A name without slashes at its ends and without .yaml: 'schema/env'."""
    return path.strip("/").removesuffix(".yaml")


def below(group: str) -> list[str]:
    """The groups and configurations directly below a group, '' for the root."""
    prefix = f"{plain(group)}/".lstrip("/")
    return [name.removeprefix(prefix).partition("/")[0] for name in nodes() if name.startswith(prefix)]


def writable(node: type) -> DictConfig:
    """A frozen dataclass as a config node that YAML and the command line may change."""
    config: DictConfig = pickle.loads(pickled(node))
    return config


@cache
def pickled(node: type) -> bytes:
    """The bytes of a dataclass's config node, which are quicker to copy than the node."""
    return pickle.dumps(converted(node))


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
