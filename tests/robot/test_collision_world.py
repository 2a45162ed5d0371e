"""Contact and rays against what can be worked out by hand, or by a fine search."""

from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.geometry import ray_ranges, rectangle_distance, wrapped
from curionav_cli.robot.collision_world import MARGIN, CollisionWorld
from curionav_cli.world.scene.scene import Scene

RADIUS = 0.18


@pytest.fixture
def box():
    """An open floor of 4 x 4 m with a box of 1 x 1 m, from (2, 1) to (3, 2)."""
    return CollisionWorld(Scene.from_dict({
        "name": "box", "size": [4.0, 4.0], "cell": 0.1, "radius": RADIUS, "camera": 0.45, "start": [0.5, 0.5, 0],
        "furniture": [{"kind": "box", "x": 2.5, "y": 1.5, "w": 1.0, "d": 1.0, "h": 0.4}]}))


def test_angles_are_wrapped_to_the_half_open_circle():
    assert wrapped(3 * np.pi) == pytest.approx(np.pi) and wrapped(-np.pi) == pytest.approx(np.pi)
    assert wrapped(-3.0) == pytest.approx(-3.0) and wrapped(7.0) == pytest.approx(7.0 - 2 * np.pi)


def test_rays_end_where_they_meet_a_rectangle(box):
    angle = np.array([0.0, np.pi, np.pi / 2, -np.pi / 2, np.pi / 4])
    ranges = box.ranges(1.0, 1.5, np.cos(angle), np.sin(angle), far=9.0)
    assert ranges == pytest.approx([1.0, 1.0, 2.5, 1.5, 2.5 * np.sqrt(2)])
    assert box.ranges(1.0, 1.5, np.array([1.0]), np.array([0.0]), far=0.9).tolist() == [np.inf]


def test_a_ray_along_an_edge_and_one_that_just_misses():
    low, high = np.array([[1.0, 1.0]]), np.array([[2.0, 2.0]])
    sine = np.array([0.0, 0.0])
    assert ray_ranges(0.0, 1.5, np.array([1.0, -1.0]), sine, low, high).tolist() == [1.0, np.inf]
    assert ray_ranges(0.0, 0.999, np.array([1.0]), np.array([0.0]), low, high).tolist() == [np.inf]


def test_rays_agree_with_a_march_through_the_lab(large_lab):
    around, rng = CollisionWorld(large_lab), np.random.default_rng(0)
    x, y, angle = 1.3, 7.0, rng.uniform(-np.pi, np.pi, 25)
    found = around.ranges(x, y, np.cos(angle), np.sin(angle), far=8.0)
    at = np.arange(0.0, 8.0, 0.005)
    px, py = x + np.cos(angle)[:, None] * at, y + np.sin(angle)[:, None] * at
    inside = np.zeros(px.shape, bool)
    for low, high in zip(around.low, around.high, strict=True):
        inside |= rectangle_distance(px, py, low, high) == 0.0
    marched = np.where(inside.any(1), at[inside.argmax(1)], np.inf)
    assert np.isfinite(found).sum() > 15 and np.array_equal(np.isfinite(found), np.isfinite(marched))
    met = np.isfinite(found)
    assert np.abs(found[met] - marched[met]).max() < 0.006


@pytest.mark.parametrize(("start", "way", "free"), [
    ((1.0, 1.5), (1.5, 0.0), 1.0 - RADIUS - MARGIN),      # the face
    ((1.0, 0.7), (2.0, 0.0), 2.0),                        # 0.3 m beside it
    ((1.0, 0.9), (2.0, 0.0), 1.0 - np.sqrt(RADIUS**2 - 0.1**2) - MARGIN),  # the corner
    ((1.0, 1.5), (-1.5, 0.0), 1.0 - RADIUS - MARGIN),     # the outer wall
    ((2.0 - RADIUS - MARGIN, 1.5), (-0.5, 0.0), 0.5),     # away from what it touches
    ((2.0 - RADIUS - MARGIN, 1.5), (0.0, 0.4), 0.4),      # along it
    ((2.0 - RADIUS - MARGIN, 1.5), (0.2, 0.0), 0.0),
])
def test_a_disc_comes_as_far_as_its_rim_allows(box, start, way, free):
    assert box.travel(*start, *way, RADIUS) == pytest.approx(free, abs=1e-9)


def test_no_way_ever_leads_into_anything(large_lab):
    around, rng = CollisionWorld(large_lab), np.random.default_rng(1)
    x, y = large_lab.plan.start[:2]
    touched = 0
    for way in rng.uniform(0.0, 0.5, 3000):
        angle = rng.uniform(-np.pi, np.pi)
        free = around.travel(x, y, way * np.cos(angle), way * np.sin(angle), RADIUS)
        x, y, touched = x + free * np.cos(angle), y + free * np.sin(angle), touched + (free < way)
        assert rectangle_distance(x, y, around.low.T, around.high.T).min() >= RADIUS - 1e-12
    assert touched > 100


def test_one_that_overlaps_something_may_leave_and_not_go_deeper(box):
    assert box.travel(1.9, 1.5, -0.3, 0.0, RADIUS) == pytest.approx(0.3)
    assert box.travel(1.9, 1.5, 0.05, 0.0, RADIUS) == 0.0


def test_it_is_known_where_it_touches(box):
    assert box.touching(2.0 - RADIUS - MARGIN, 1.5, RADIUS) == pytest.approx(0.0)
    assert box.touching(2.5, 2.0 + RADIUS + MARGIN, RADIUS) == pytest.approx(-np.pi / 2)
    assert box.touching(1.0, 1.5, RADIUS) is None


def test_cells_of_a_map_that_are_no_floor_are_in_the_way(small_room):
    around = CollisionWorld(small_room)
    assert len(around.low) == small_room.boxes.solid(small_room.agent_height).sum(), "a room of four walls is all floor"
    hole = np.ones((40, 20), bool)
    hole[30, 10] = False
    holed = replace(small_room, plan=replace(small_room.plan, floor=hole))
    low, high = CollisionWorld(holed).low[-1], CollisionWorld(holed).high[-1]
    assert low == pytest.approx([1.0, 3.0]) and high == pytest.approx([1.1, 3.1])
