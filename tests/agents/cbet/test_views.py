"""The view that changes are taken of: turning changes no panorama, and every picture of the robot's own camera."""

import numpy as np
import pytest

from curionav_cli.agents.cbet.transitions import BLOCKED, MOVED, TURNED
from curionav_cli.agents.cbet.views import Ego, Panorama
from curionav_cli.world.render.renderer import Renderer

FORWARD, LEFT, RIGHT = 0, 1, 2


@pytest.fixture
def pano(small_room):
    return Panorama(small_room, "numpy", 0)


def test_a_panorama_is_four_pictures_by_the_compass(pano, small_room, walk):
    life = walk([FORWARD, LEFT, LEFT, LEFT, FORWARD, RIGHT])
    pictures, which = pano(life)
    fresh = Renderer(small_room)
    for (x, y, _), number in zip(life.episode.pose, which, strict=True):
        for view, heading in enumerate((0, 9, 18, 27)):
            assert (pictures[number, view] == fresh.render(x, y, heading)[0][0]).all()


def test_turning_and_bumping_change_no_panorama(pano, walk):
    life = walk([LEFT, RIGHT, RIGHT, FORWARD] + [LEFT] * 18 + [FORWARD] * 5)
    pictures, which = pano(life)
    assert life.kind.tolist()[:4] == [TURNED, TURNED, TURNED, MOVED] and life.kind[-1] == BLOCKED
    same = which[:-1] == which[1:]
    assert (same == (life.kind != MOVED)).all()
    moved = np.flatnonzero(life.kind == MOVED)
    assert len(moved) and all((pictures[which[t]] != pictures[which[t + 1]]).any() for t in moved)
    assert len(pictures) == len(np.unique(life.episode.pose[:, :2], axis=0))


def test_turning_changes_the_own_picture_and_bumping_does_not(walk):
    life = walk([LEFT, FORWARD] + [LEFT] * 17 + [FORWARD] * 5)
    pictures, which = Ego()(life)
    changed = (pictures[which[1:]] != pictures[which[:-1]]).any(axis=(1, 2, 3, 4))
    assert (changed == (life.kind != BLOCKED)).all() and (life.kind == BLOCKED).any()
    assert (pictures[which][:, 0] == life.episode.image).all()


def test_the_last_step_leads_back_to_the_start(walk):
    assert walk([FORWARD, LEFT, LEFT]).reached.tolist() == [1, 2, 0]
