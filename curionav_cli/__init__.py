"""curionav: a robot learns to navigate from scratch with a world model and curiosity.

Importing it, before or after gymnasium, registers curionav/SmallRoom-v0 and the other environments. gymnasium itself
is not imported for that, which keeps --help and completions quick; so are the functions of api.py (docs/python.md),
which are imported when one of them is named.
"""

import sys
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import TYPE_CHECKING, Any

from curionav_cli.errors import UserError

if TYPE_CHECKING:
    from curionav_cli.api import batches, compose, explore, load_run, load_runs

__version__ = "0.1.0"
__all__ = ["UserError", "batches", "compose", "explore", "load_run", "load_runs"]


def __getattr__(name: str) -> Any:
    """Return a function of api.py, imported when it is first named (PEP 562)."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from curionav_cli import api

    return getattr(api, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class RegisterAfterGymnasium:
    """An import finder that registers our environments once gymnasium is imported, and then removes itself.

    importlib.util.find_spec, by which torchrl asks whether gymnasium is installed, imports nothing and leaves it.
    """

    @classmethod
    def find_spec(cls, name: str, path: object = None, target: ModuleType | None = None) -> ModuleSpec | None:
        if name != "gymnasium":
            return None
        specs = (finder.find_spec(name, None, target) for finder in sys.meta_path if finder is not cls)
        spec = next((spec for spec in specs if spec), None)
        if spec is None or spec.loader is None:
            return spec
        execute = spec.loader.exec_module

        def execute_and_register(module: ModuleType) -> None:
            if cls in sys.meta_path:
                sys.meta_path.remove(cls)
            execute(module)
            register()
        spec.loader.exec_module = execute_and_register  # type: ignore[method-assign]
        return spec


def register() -> None:
    """Register our environments with gymnasium, which this imports."""
    from curionav_cli.world.registration import register

    register()


if "gymnasium" in sys.modules:
    register()
else:
    sys.meta_path.insert(0, RegisterAfterGymnasium)
