"""Refuse what a config from elsewhere may not do: run code, set the environment, or write outside the run folder.

Hydra itself calls what is named under hydra.callbacks and under `()` in its logging, and sets environment variables.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import reduce
from typing import Any

from omegaconf import DictConfig, OmegaConf

from curionav_cli.errors import ConfigError

TARGETS = {  # nothing else is called, and nowhere else
    "hydra.launcher._target_": r"(hydra\._internal\.core_plugins|hydra_plugins\.\w+)\.\w+\.\w+Launcher",
    "hydra.sweeper._target_": r"(hydra\._internal\.core_plugins|hydra_plugins\.\w+)\.\w+\.\w+Sweeper",
    "hydra.sweeper.sampler._target_": r"optuna\.samplers\.\w+Sampler",
}
NAMES = {  # of folders and files within the run's, and of the run's within the sweep's
    "output_subdir": r"[\w.-]+", "job.name": r"[\w.-]+",
    "sweep.subdir": r"([\w.=,/ -]|\$\{(hydra\.job\.\w+|env\.name|(agent|robot|loop)\.[\w.]+|seed|scale)\})*",
}
LOGGING = "logging."
STORED = r"sqlite:///\$\{hydra\.sweep\.dir\}/[\w.-]+|[\w.-]*"  # of a search: a file in the sweep's folder
IN_THE_RUN = "${hydra.runtime.output_dir}/"


def refuse_callables(config: DictConfig) -> None:
    """Refuse a composed configuration that names something for Hydra to call or to open. Raises ConfigError."""
    hydra: Any = OmegaConf.to_container(config.hydra, resolve=False)
    for key, form in NAMES.items():
        name = str(reduce(dict.__getitem__, key.split("."), hydra) or "x")
        parts = name.split("/")
        if "override_dirname" in name:  # which holds the values of the sweep
            parts += re.split("[/=]", str(hydra["sweeper"].get("params")))
        if not re.fullmatch(form, name) or ".." in parts or not parts[0]:
            raise ConfigError(f"hydra.{key}: {name} would be written outside the run's folder. Leave it out.")
    for key in ("callbacks", "job.env_set"):
        if OmegaConf.select(config.hydra, key):
            raise ConfigError(f"hydra.{key}: a config may not run code or set the environment. Use the shell for it.")
    if hydra["sweeper"].get("custom_search_space"):
        raise ConfigError("hydra.sweeper.custom_search_space would be called; a config may not name what is called. "
                          "Name what is searched: 'agent.gamma=interval(0.9,0.99)'.")
    for key, value in leaves(hydra, "hydra"):
        leaf, logs, text = key.rpartition(".")[2], "_logging." in key, str(value)
        called = {"_target_": not re.fullmatch(TARGETS.get(key, ""), text), "()": logs,
                  "class": logs and not text.startswith(LOGGING)}
        if called.get(leaf) or (text.startswith("ext://") and not text.startswith("ext://sys.std")):
            raise ConfigError(f"{key}: {value} would be called; a config may not name what is called. Leave it out.")
        if key.startswith("hydra.sweeper.storage") and not re.fullmatch(STORED, text):
            raise ConfigError(f"{key}: a search is kept in the sweep's folder, sqlite:///${{hydra.sweep.dir}}/..., "
                              f"not at {value}.")
        if logs and leaf == "filename" and (not text.startswith(IN_THE_RUN) or ".." in text):
            raise ConfigError(f"{key}: a log stands in the run's folder, {IN_THE_RUN}..., not at {value}.")


def leaves(tree: Any, key: str) -> Iterator[tuple[str, Any]]:
    """Yield all keys and values of a tree, those in lists too: ('hydra.launcher._target_', '...'), ..."""
    inner = tree.items() if isinstance(tree, dict) else enumerate(tree) if isinstance(tree, list) else ()
    for name, value in inner:
        yield from leaves(value, f"{key}.{name}")
    if not isinstance(tree, dict | list):
        yield key, tree
