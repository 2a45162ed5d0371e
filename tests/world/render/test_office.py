"""A map of 100 x 100 m: its size must show neither in a frame's work nor in memory."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from office import write_office

from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def office(tmp_path_factory) -> Scene:
    return Scene.from_dict(*plain("map", map=str(write_office(tmp_path_factory.mktemp("office")))))


def test_a_frame_tries_few_boxes_of_many(office: Scene, small_room: Scene, draw_spots) -> None:
    assert office.size == (100.0, 100.0) and len(office.boxes) > 2000
    assert office.plan.visitable.sum() > 2e6
    camera = Renderer(office).camera
    x, y, heading = draw_spots(office, 50, 0)
    tried = camera.culling(x, y, np.cos(heading * np.pi / 18), np.sin(heading * np.pi / 18)).boxes
    assert (tried <= len(office.boxes)).sum(axis=1).mean() < 6 * len(small_room.boxes)


def test_choosing_boxes_changes_no_near_picture(office: Scene, draw_spots, monkeypatch) -> None:
    """Trying the boxes of a wedge is trying all within reach: beyond it there is haze."""
    x, y, heading = draw_spots(office, 6, 1)
    rgb, depth = Renderer(office).render(x, y, heading)
    monkeypatch.setattr("curionav_cli.world.render.culling.FEW", 10**9)
    every, exact = Renderer(office).render(x, y, heading)
    assert rgb.tobytes() == every.tobytes() and depth.tobytes() == exact.tobytes()


MOST = """
import resource, sys
from curionav_cli.world.registration import make
env = make("map", map=sys.argv[1])
env.reset(seed=0)
for action in [0, 1] * 50:
    env.step(action)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3)
"""


def test_it_stays_under_a_gigabyte(tmp_path: Path) -> None:
    path = write_office(tmp_path)
    done = subprocess.run([sys.executable, "-c", MOST, str(path)], capture_output=True, text=True, check=True)
    assert float(done.stdout) < 1000
