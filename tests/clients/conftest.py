"""Other people's trainers on our worlds: the extra `clients`, the marker `clients`, `make clients`."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import pytest

import curionav_cli.world.registration as registration
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain


@pytest.fixture(scope="session")
def a_mesh(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The small room as a scan."""
    from curionav_cli.world.scan.export import export

    file = tmp_path_factory.mktemp("scan") / "room.glb"
    export(Scene.from_dict(*plain("small_room")), file)
    return str(file)


@pytest.fixture
def world(a_map: str, a_mesh: str) -> Callable[..., dict[str, Any]]:
    """world(name): what gymnasium.make takes to make it."""
    registration.register()

    def named(name: str, **settings: Any) -> dict[str, Any]:
        where = {"curionav/Map-v0": {"map": a_map}, "curionav/Scan-v0": {"mesh": a_mesh}}.get(name, {})
        return {"id": f"curionav_cli:{name}", **where, **settings}
    return named


@pytest.fixture(autouse=True)
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stable-Baselines3's learn() makes a folder for its log, in /tmp unless this names another; a scan is kept in the
    user's cache."""
    monkeypatch.setenv("SB3_LOGDIR", str(tmp_path / "sb3"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def sb3() -> None:
    """Skip where Stable-Baselines3 is not installed."""
    pytest.importorskip("sb3_contrib")


@pytest.fixture
def made(world) -> Callable[..., gymnasium.Env]:
    """made(name): it."""
    return lambda name, **settings: gymnasium.make(**world(name, **settings))
