"""The layers of the package, lowest first: a module imports only from layers below, or from its own."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import curionav_cli

LAYERS = (
    "errors", "constants", "geometry", "bounds", "safe_yaml", "places", "files", "decisions", "options", "records",
    "probe", "world", "robot", "live", "storage", "bags", "agents", "remote", "loop", "results", "config", "build",
    "execution", "commands", "api", "app",
)
LENT = {"torch": ("agents",), "hydra": ("config",), "omegaconf": ("config",), "matplotlib": ("results",),
        "roslibpy": ("live",), "rosbags": ("bags",), "trimesh": ("world",), "embreex": ("world",)}
PACKAGE = Path(curionav_cli.__file__).parent
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path.parent != PACKAGE or path.stem[0] != "_")


def name_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def layer_of(module: str) -> str:
    """'config.schema.Env' -> 'config.schema', 'agents.lbs_dreamer.rssm' -> 'agents'."""
    first, second = (module.split(".") + [""])[:2]
    return f"{first}.{second}" if f"{first}.{second}" in LAYERS else first


def imports(path: Path) -> set[str]:
    """Full names of what a module imports, anywhere in it; `from a import b` gives a.b and a."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return found


def own_layers(names: set[str]) -> set[str]:
    inside = {name.removeprefix("curionav_cli.") for name in names if name.startswith("curionav_cli.")}
    return {layer_of(name) for name in inside - {"__version__"}}


def test_an_upward_import_would_be_seen(tmp_path: Path) -> None:
    module = tmp_path / "module.py"
    module.write_text("def late():\n    from curionav_cli.commands import explore\n")
    assert own_layers(imports(module)) == {"commands"}


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_imports_only_from_layers_below(path: Path) -> None:
    layer = layer_of(name_of(path))
    assert layer in LAYERS, f"{layer} is not a layer"
    for used in own_layers(imports(path)):
        assert used in LAYERS, f"{name_of(path)} imports {used}, which is no layer"
        assert LAYERS.index(used) <= LAYERS.index(layer), f"{name_of(path)} imports upward: {used}"


@pytest.mark.parametrize("library", LENT)
def test_a_heavy_library_stays_in_its_layer(library: str) -> None:
    users = {layer_of(name_of(path)) for path in MODULES
             if any(name == library or name.startswith(f"{library}.") for name in imports(path))}
    assert users <= set(LENT[library])


SCHEMA = ("bounds", "world/settings", "robot/settings", "robot/docking_settings", "agents/settings",
          "live/settings", "agents/lbs_dreamer/settings", "agents/curious_mapper/settings", "agents/cbet/settings",
          "agents/sb3/settings",
          "remote/settings", "results/settings", "config/schema")


@pytest.mark.parametrize("module", SCHEMA)
def test_schema_needs_the_standard_library_only(module: str) -> None:
    allowed = {"__future__", "dataclasses", "enum", "typing", "math", "collections", "contextlib", "difflib",
               "curionav_cli"}
    used = {name.partition(".")[0] for name in imports(PACKAGE / f"{module}.py")}
    assert used <= allowed


def test_no_module_has_a_name_that_says_nothing() -> None:
    empty_names = {"utils", "common", "helpers", "misc", "tools"}
    assert not [path for path in PACKAGE.rglob("*") if path.stem in empty_names]
