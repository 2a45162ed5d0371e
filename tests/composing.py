"""What many tests compose is composed once: Hydra takes a sixth of a second for it, and for some tests that is all."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.core_plugins.file_config_source import FileConfigSource
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.utils import JobRuntime
from hydra.plugins.config_source import ConfigResult
from omegaconf import DictConfig

from curionav_cli.config.loader import copies

FOLDERS = ("hydra.run.dir=", "hydra.sweep.dir=")  # differ from test to test, and are written over what was composed
KEPT = 400


class Composed:
    """Stands in for Hydra's composing of conf/: the second time it copies. With a user's directories it composes."""

    def __init__(self) -> None:
        self.composed: dict[Any, Callable[[], DictConfig]] = {}
        self.compose = ConfigLoaderImpl.load_configuration

    def __call__(self, loader: ConfigLoaderImpl, name: str | None, overrides: list[str], *rest: Any) -> DictConfig:
        sources = [(source.provider, source.path) for source in loader.config_search_path.get_path()]
        own = [word for word in overrides if not word.startswith(FOLDERS)]
        if "user" in dict(sources) or "searchpath" in str(own) or len(overrides) - len(own) > 1:
            return self.compose(loader, name, overrides, *rest)
        key = (*sources, name, JobRuntime().get("name"), *rest, *own)
        if key not in self.composed:
            self.keep(key, self.compose(loader, name, own, *rest))
        config = self.composed[key]()
        config.hydra.runtime.cwd = str(Path.cwd())
        for word in set(overrides) - set(own):
            loader._apply_overrides_to_config(OverridesParser.create().parse_overrides([word]), config)
            config.hydra.overrides.hydra.append(word)
        return config

    def keep(self, key: Any, config: DictConfig) -> None:
        if len(self.composed) == KEPT:
            del self.composed[next(iter(self.composed))]
        self.composed[key] = copies(config)


class Read:
    """Stands in for Hydra's reading of a file, which it parses only when it has changed."""

    def __init__(self) -> None:
        self.files: dict[Any, bytes] = {}
        self.read = FileConfigSource.load_config

    def __call__(self, source: FileConfigSource, config_path: str) -> ConfigResult:
        path = Path(source.path, source._normalize_file_name(config_path))
        if not path.is_file():
            return self.read(source, config_path)
        stat = path.stat()
        key = (source.provider, str(path), stat.st_mtime_ns, stat.st_size, stat.st_ino)
        if key not in self.files:
            self.files[key] = pickle.dumps(self.read(source, config_path))
        found: ConfigResult = pickle.loads(self.files[key])
        return found


@pytest.fixture(scope="session", autouse=True)
def composed_once() -> Iterator[None]:
    compose, read = Composed(), Read()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ConfigLoaderImpl, "load_configuration", lambda *words: compose(*words))
        patch.setattr(FileConfigSource, "load_config", lambda *words: read(*words))
        yield
