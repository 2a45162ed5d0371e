"""Hydra's plugins, but for those that cannot be imported: one line names each, and Hydra passes it over."""

from __future__ import annotations

import importlib
import pkgutil
import sys
import warnings
from collections.abc import Iterator
from functools import cache
from importlib.metadata import distributions

from hydra.core.plugins import Plugins

from curionav_cli.errors import SoundnessWarning

NAMESPACE = "hydra_plugins"


@cache
def broken() -> dict[str, str]:
    """Package -> why it cannot be imported; {} in most environments. Hydra looks for its plugins here, once a process.

    Without this one of them, also one that nobody asked for, ends every command by its traceback.
    """
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("error", r"\s*Error importing '")  # what Hydra passes over itself
            Plugins.instance()
        return {}
    except Exception:  # of any kind, since a plugin's module can do anything
        found: dict[str, str] = {}
        for module, why in blocked():
            found.setdefault(distribution(module.split(".")[1]), why)
    Plugins.instance()
    for package, why in found.items():
        warnings.warn(f"The Hydra plugin {package} cannot be imported ({why}). It is left out.", SoundnessWarning,
                      stacklevel=2)
    return found


def blocked() -> Iterator[tuple[str, str]]:
    """The modules of plugins that cannot be imported; nobody can from now on, and Hydra does not try."""
    namespace = importlib.import_module(NAMESPACE)
    for found in pkgutil.walk_packages(namespace.__path__, f"{NAMESPACE}.", onerror=lambda name: None):
        if found.name.rpartition(".")[2].startswith("_"):  # Hydra does not look into these
            continue
        try:
            importlib.import_module(found.name)
        except Exception as error:
            sys.modules[found.name] = None  # type: ignore[assignment]
            yield found.name, f"{type(error).__name__}: {next(iter(str(error).splitlines()), '')}"


def distribution(package: str) -> str:
    """'hydra-ax-sweeper 1.2.0'; where none has its files, the package's own name."""
    for one in distributions():
        if any(str(file).startswith(f"{NAMESPACE}/{package}") for file in one.files or ()):
            return f"{one.name} {one.version}"
    return f"{NAMESPACE}.{package}"
