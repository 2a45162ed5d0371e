"""Leave out the Hydra plugins that cannot be imported, with one warning for each."""

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
    """Package -> why it cannot be imported. Hydra loads its plugins here, once a process.

    Without this, any broken plugin that is installed ends every command with a traceback.
    """
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("error", r"\s*Error importing '")  # Hydra itself only warns of these
            Plugins.instance()
        return {}
    except Exception:  # of any type, as a plugin's module can do anything
        found: dict[str, str] = {}
        for module, why in blocked():
            found.setdefault(distribution(module.split(".")[1]), why)
    Plugins.instance()
    for package, why in found.items():
        warnings.warn(f"The Hydra plugin {package} cannot be imported ({why}). It is left out.", SoundnessWarning,
                      stacklevel=2)
    return found


def blocked() -> Iterator[tuple[str, str]]:
    """The plugin modules that cannot be imported, and why; each is blocked, so that Hydra does not try it."""
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
    """The distribution of a plugin, such as 'hydra-ax-sweeper 1.2.0'; else the package's name."""
    for installed in distributions():
        if any(str(file).startswith(f"{NAMESPACE}/{package}") for file in installed.files or ()):
            return f"{installed.name} {installed.version}"
    return f"{NAMESPACE}.{package}"
