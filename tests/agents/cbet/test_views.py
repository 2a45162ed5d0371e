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


def test_a_panorama_is_four_images_by_the_compass(pano, small_room, walk):
    transitions = walk([FORWARD, LEFT, LEFT, LEFT, FORWARD, RIGHT])
    images, which = pano(transitions)
    fresh = Renderer(small_room)
    for (x, y, _), number in zip(transitions.episode.pose, which, strict=True):
        for view, heading in enumerate((0, 9, 18, 27)):
            assert (images[number, view] == fresh.render(x, y, heading)[0][0]).all()


def test_turning_and_bumping_change_no_panorama(pano, walk):
    transitions = walk([LEFT, RIGHT, RIGHT, FORWARD] + [LEFT] * 18 + [FORWARD] * 5)
    images, which = pano(transitions)
    assert transitions.kind.tolist()[:4] == [TURNED, TURNED, TURNED, MOVED] and transitions.kind[-1] == BLOCKED
    same = which[:-1] == which[1:]
    assert (same == (transitions.kind != MOVED)).all()
    moved = np.flatnonzero(transitions.kind == MOVED)
    assert len(moved) and all((images[which[t]] != images[which[t + 1]]).any() for t in moved)
    assert len(images) == len(np.unique(transitions.episode.pose[:, :2], axis=0))


def test_turning_changes_the_own_image_and_bumping_does_not(walk):
    transitions = walk([LEFT, FORWARD] + [LEFT] * 17 + [FORWARD] * 5)
    images, which = Ego()(transitions)
    changed = (images[which[1:]] != images[which[:-1]]).any(axis=(1, 2, 3, 4))
    assert (changed == (transitions.kind != BLOCKED)).all() and (transitions.kind == BLOCKED).any()
    assert (images[which][:, 0] == transitions.episode.image).all()


def test_the_last_step_leads_back_to_the_start(walk):
    assert walk([FORWARD, LEFT, LEFT]).reached.tolist() == [1, 2, 0]
