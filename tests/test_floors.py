"""The rooms of the house, ground floor first: a module imports only from floors below, or its own room."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

import curionav_cli

ROOMS = (
    "errors", "constants", "geometry", "bounds", "safe_yaml", "files", "records", "world", "robot", "storage", "agents",
    "remote", "loop", "results", "config", "build", "execution", "commands", "app",
)
LENT = {"torch": ("agents",), "hydra": ("config",), "omegaconf": ("config",), "matplotlib": ("results",)}
PACKAGE = Path(curionav_cli.__file__).parent
MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path.parent != PACKAGE or path.stem[0] != "_")


def name_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE).with_suffix("").parts
    return ".".join(part for part in parts if part != "__init__")


def room_of(module: str) -> str:
    """'config.schema.Env' -> 'config.schema', 'agents.lbs_dreamer.rssm' -> 'agents'."""
    first, second = (module.split(".") + [""])[:2]
    return f"{first}.{second}" if f"{first}.{second}" in ROOMS else first


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


def own_rooms(names: set[str]) -> set[str]:
    inside = {name.removeprefix("curionav_cli.") for name in names if name.startswith("curionav_cli.")}
    return {room_of(name) for name in inside - {"__version__"}}


def test_an_upward_import_would_be_seen(tmp_path: Path) -> None:
    module = tmp_path / "module.py"
    module.write_text("def late():\n    from curionav_cli.commands import explore\n")
    assert own_rooms(imports(module)) == {"commands"}


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_imports_only_from_floors_below(path: Path) -> None:
    room = room_of(name_of(path))
    assert room in ROOMS, f"{room} is not a room of the house"
    for used in own_rooms(imports(path)):
        assert used in ROOMS, f"{name_of(path)} imports {used}, which is no room"
        assert ROOMS.index(used) <= ROOMS.index(room), f"{name_of(path)} imports upward: {used}"


@pytest.mark.parametrize("library", LENT)
def test_a_heavy_library_stays_in_its_room(library: str) -> None:
    users = {room_of(name_of(path)) for path in MODULES
             if any(name == library or name.startswith(f"{library}.") for name in imports(path))}
    assert users <= set(LENT[library])


SCHEMA = ("bounds", "world/settings", "robot/settings", "robot/docking_settings", "agents/settings",
          "agents/lbs_dreamer/settings", "agents/curious_mapper/settings", "agents/cbet/settings", "remote/settings",
          "config/schema")


@pytest.mark.parametrize("module", SCHEMA)
def test_schema_needs_the_standard_library_only(module: str) -> None:
    allowed = {"__future__", "dataclasses", "enum", "typing", "math", "collections", "curionav_cli"}
    used = {name.partition(".")[0] for name in imports(PACKAGE / f"{module}.py")}
    assert used <= allowed


def test_no_drawer_without_a_name() -> None:
    drawers = {"utils", "common", "helpers", "misc", "tools"}
    assert not [path for path in PACKAGE.rglob("*") if path.stem in drawers]
