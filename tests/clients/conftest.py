"""Other people's trainers on our worlds: the extra `clients`, the marker `clients`, `make clients`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import pytest

import curionav_cli.world.registration as registration


@pytest.fixture
def world(a_map: str) -> Callable[..., dict[str, Any]]:
    """world(name): what gymnasium.make takes to make it."""
    registration.register()

    def named(name: str, **settings: Any) -> dict[str, Any]:
        where = {"map": a_map} if name == "curionav/Map-v0" else {}
        return {"id": f"curionav_cli:{name}", **where, **settings}
    return named


@pytest.fixture
def made(world) -> Callable[..., gymnasium.Env]:
    """made(name): it."""
    return lambda name, **settings: gymnasium.make(**world(name, **settings))
