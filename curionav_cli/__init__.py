"""curionav: a robot learns to navigate from scratch with a world model and curiosity.

Importing it, before or after gymnasium, registers curionav/SmallRoom-v0 and the other worlds. gymnasium itself is
not imported for that: the command line answers --help and completions in a fifth of a second.
"""

import sys
from importlib.machinery import ModuleSpec
from types import ModuleType

__version__ = "0.1.0"


class WhenGymnasiumComes:
    """A finder that registers our worlds once somebody has imported gymnasium, and then steps aside.

    Who only asks whether gymnasium is there (importlib.util.find_spec, as torchrl does) gets the answer, and it stays.
    """

    @classmethod
    def find_spec(cls, name: str, path: object = None, target: ModuleType | None = None) -> ModuleSpec | None:
        if name != "gymnasium":
            return None
        others = (finder.find_spec(name, None, target) for finder in sys.meta_path if finder is not cls)
        spec = next((found for found in others if found), None)
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
    from curionav_cli.world.registration import register

    register()


if "gymnasium" in sys.modules:
    register()
else:
    sys.meta_path.insert(0, WhenGymnasiumComes)
