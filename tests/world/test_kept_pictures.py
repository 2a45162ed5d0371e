"""Pictures of a place: the ones that are kept are the ones that would be drawn."""

from __future__ import annotations

import numpy as np
import pytest

from curionav_cli.constants import FORWARD, LEFT, RIGHT
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.pictures import Pictures
from curionav_cli.world.scene.scene import Scene


def test_turning_back_shows_what_drawing_again_would(small_room: Scene) -> None:
    env, drawn = NavigationEnv(small_room), NavigationEnv(small_room)
    env.reset(seed=0)
    drawn.reset(seed=0)
    for action in (LEFT, RIGHT, LEFT, FORWARD, RIGHT, LEFT, FORWARD):
        drawn._pictures.forget()
        seen, again = env.step(action)[0], drawn.step(action)[0]
        assert seen["image"].tobytes() == again["image"].tobytes()
        assert seen["depth"].tobytes() == again["depth"].tobytes()


def test_a_changed_copy_changes_no_later_picture(small_room: Scene) -> None:
    env = NavigationEnv(small_room)
    first = env.reset(seed=0)[0]["image"]
    before = first.copy()
    first[:] = 0
    env.step(LEFT)
    assert (env.step(RIGHT)[0]["image"] == before).all()


def test_many_worlds_keep_few_pictures_each() -> None:
    pictures, image, depth = Pictures(2048), np.zeros((64, 64, 3), np.uint8), np.zeros((64, 64), np.float32)
    pictures.keep(0, 3, image, depth)
    pictures.keep(0, 4, image, depth)
    assert pictures.missing([0, 1], [3, 4] + [0] * 2046) == [0, 1]
    with pytest.raises(KeyError):
        pictures.one(0, 3)
