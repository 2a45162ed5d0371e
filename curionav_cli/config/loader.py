"""Hydra's loader of configurations, which composes the same overrides once however often it is asked."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from copy import copy, deepcopy
from functools import partial
from typing import Any

from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.config_repository import ConfigRepository
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.types import RunMode
from omegaconf import DictConfig

KEPT = 8  # compositions, of some 100 kB each


def copies(config: DictConfig) -> Callable[[], DictConfig]:
    """What makes copies of a configuration: by pickle, five times quicker than deepcopy.

    Hydra may have loaded a plugin twice, and pickle refuses the classes of the first time.
    """
    try:
        return partial(pickle.loads, pickle.dumps(config))
    except pickle.PicklingError:
        return partial(deepcopy, config)


class Repository(ConfigRepository):
    """Hydra's repository, whose copies share their sources, which give out copies of configurations anyway."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Repository:
        return copy(self)


class Loader(ConfigLoaderImpl):
    """Compose overrides, or copy what they composed to before. It lasts for one command, as its files are read once."""

    def __init__(self, *words: Any, **named: Any):
        super().__init__(*words, **named)
        self.repository = Repository(self.config_search_path)
        self.composed: dict[tuple[Any, ...], Callable[[], DictConfig]] = {}

    def load_configuration(self, config_name: str | None, overrides: list[str], run_mode: RunMode,
                           from_shell: bool = True, validate_sweep_overrides: bool = True) -> DictConfig:
        """Compose as Hydra does; each caller gets a configuration of its own. Raises what Hydra raises."""
        key = (config_name, run_mode, from_shell, validate_sweep_overrides, *overrides)
        if key not in self.composed:
            self.keep(key, super().load_configuration(
                config_name, overrides, run_mode, from_shell, validate_sweep_overrides))
        return self.composed[key]()

    def keep(self, key: tuple[Any, ...], config: DictConfig) -> None:
        """Keep a composition, in place of the oldest one."""
        if len(self.composed) == KEPT:
            del self.composed[next(iter(self.composed))]
        self.composed[key] = copies(config)

    def pin(self, name: str, overrides: list[str], mode: RunMode, pinned: str) -> None:
        """Derive what `overrides` and then `pinned`, an override of a key of Hydra's own, compose to, for later."""
        config = self.load_configuration(name, overrides, mode)
        self._apply_overrides_to_config(OverridesParser.create().parse_overrides([pinned]), config)
        config.hydra.overrides.hydra.append(pinned)
        self.keep((name, mode, True, True, *overrides, pinned), config)

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what was composed, as a launcher's workers compose other jobs."""
        return {**vars(self), "composed": {}}
