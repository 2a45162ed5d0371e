"""Scenes for the tests of this room."""

from __future__ import annotations

import copy
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

SMALL: dict[str, Any] = {
    "name": "cell", "size": [3.0, 2.0], "cell": 0.1, "radius": 0.15, "camera": 0.45, "height": 2.4,
    "start": [0.5, 0.5, 0],
    "walls": [{"line": [2.0, 0.0, 2.0, 2.0], "gaps": [[0.6, 0.9]]}],
    "furniture": [{"kind": "table", "x": 1.2, "y": 1.4, "name": "table"},
                  {"kind": "box", "x": 0.4, "y": 1.6, "name": "box"}],
    "posters": [{"at": [0.0, 0.8], "face": "east"}],
}


@pytest.fixture
def small() -> dict[str, Any]:
    """A scene of 3 x 2 m as a plain dict to change: a wall with a door, a table, a box, a poster."""
    return copy.deepcopy(SMALL)


@pytest.fixture(scope="session")
def small_room() -> Scene:
    return Scene.from_dict(*plain("small_room"))


def spots(scene: Scene, count: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Random poses on visitable cells: x, y, heading."""
    rng = np.random.default_rng(seed)
    rows, columns = np.nonzero(scene.plan.visitable)
    which = rng.integers(0, len(rows), count)
    x, y = ((at[which] + rng.random(count)) * scene.plan.cell for at in (columns, rows))
    return x, y, rng.integers(0, 36, count)


@pytest.fixture(scope="session")
def draw_spots():
    return spots


@pytest.fixture
def real_maps() -> Path:
    """The folder of real ROS maps, which are no part of the project."""
    beside = Path(__file__).resolve().parents[2].parent / "shared" / "maps"
    folder = Path(os.environ.get("CURIONAV_MAPS", beside))
    if not folder.is_dir():
        pytest.skip("no real maps here; CURIONAV_MAPS names their folder")
    return folder
