"""Scene files: what they give, what they refuse and how, what the episodes change."""

from __future__ import annotations

import numpy as np
import pytest

from curionav_cli.errors import SceneError
from curionav_cli.geometry import rectangle_distance
from curionav_cli.world.materials.materials import exists
from curionav_cli.world.scene.furniture import KINDS
from curionav_cli.world.scene.reachability import fingerprint, trimmed
from curionav_cli.world.scene.scene import Scene


def recount(scene: Scene) -> np.ndarray:
    """The visitable cells by definition, cell by cell, box by box, and a flood from the start."""
    plan, boxes = scene.plan, scene.boxes
    solid = boxes.solid(scene.agent_height)
    low, high = boxes.low[solid, :2], boxes.high[solid, :2]
    free = np.zeros(plan.visitable.shape, bool)
    for row, column in np.ndindex(free.shape):
        x, y = (column + 0.5) * plan.cell, (row + 0.5) * plan.cell
        edge = min(x, y, scene.size[0] - x, scene.size[1] - y)
        point = np.array(x), np.array(y)
        away = [float(rectangle_distance(*point, *box)) for box in zip(low, high, strict=True)]
        free[row, column] = min(edge, *away) > plan.radius + 1e-9
    reached, todo = np.zeros_like(free), [tuple(int(at) for at in plan.cells(plan.start.x, plan.start.y))]
    while todo:
        row, column = todo.pop()
        inside = 0 <= row < free.shape[0] and 0 <= column < free.shape[1]
        if inside and free[row, column] > reached[row, column]:
            reached[row, column] = True
            todo += [(row + 1, column), (row - 1, column), (row, column + 1), (row, column - 1)]
    return reached


def test_small_room_is_what_the_paper_says(small_room: Scene) -> None:
    assert small_room.size == (2.0, 4.0)
    assert small_room.plan.floor.sum() == 800
    assert (small_room.plan.radius, small_room.camera, small_room.plan.cell) == (0.18, 0.45, 0.1)
    assert not small_room.changing
    assert np.array_equal(small_room.plan.visitable, recount(small_room))


def test_only_the_floor_of_the_rooms_can_be_visited() -> None:
    half = {"name": "half", "size": [4.0, 4.0], "cell": 0.1, "radius": 0.15, "camera": 0.45, "height": 2.4,
            "start": [1.0, 1.0, 0], "rooms": [{"rect": [0, 0, 2, 4]}]}
    plan = Scene.from_dict(half).plan
    assert plan.floor.sum() == 20 * 40 and (plan.visitable <= plan.floor).all()
    assert plan.visitable.sum() == (20 - 2) * (40 - 4), "the robot keeps off the walls, and stays in the room"
    with pytest.raises(SceneError, match=r"the start \(3, 1\)"):
        Scene.from_dict({**half, "start": [3.0, 1.0, 0]})


def test_a_door_is_passed_and_a_wall_is_not(small) -> None:
    through = Scene.from_dict(small).plan.visitable
    small["walls"][0]["gaps"] = []
    closed = Scene.from_dict(small).plan.visitable
    assert through[:, 22:].any()
    assert not closed[:, 22:].any()
    assert np.array_equal(closed, recount(Scene.from_dict(small)))


def test_a_robot_lower_than_the_table_drives_under_it(small) -> None:
    low = Scene.from_dict({**small, "agent_height": 0.5}).plan.visitable
    tall = Scene.from_dict({**small, "agent_height": 0.9}).plan.visitable
    assert low[14, 12] and not tall[14, 12]
    assert low.sum() > tall.sum()


@pytest.mark.parametrize(("change", "said"), [
    ({"wals": []}, "here.yaml: a scene has no key wals. Did you mean walls?"),
    ({"furniture": [{"kind": "box", "x": 1, "y": 1, "hight": 2}]},
     "here.yaml: furniture[0] has no key hight. It has: kind, x, y"),
    ({"furniture": [{"kind": "sofaa", "x": 1, "y": 1}]}, "furniture[0].kind: there is no furniture sofaa"),
    ({"furniture": [{"kind": "box", "x": "left", "y": 1}]}, "here.yaml: furniture[0].x must be a number"),
    ({"furniture": [{"kind": "box", "x": 1}]}, "here.yaml: furniture[0] lacks the key y"),
    ({"furniture": [{"kind": "box", "x": 1, "y": 1, "turn": 45}]}, "turn must be 0, 90, 180 or 270"),
    ({"furniture": [{"kind": "box", "x": 1, "y": 1, "material": "gold"}]}, "no material gold"),
    ({"rooms": [{"rect": [0, 0, 1, 1], "flor": "planks"}]}, "rooms[0] has no key flor. Did you mean floor?"),
    ({"rooms": [{"rect": [0, 0, 1]}]}, "rooms[0].rect must be 4 numbers"),
    ({"walls": [{"line": [0, 0, 1, 1]}]}, "must run along x or along y"),
    ({"walls": [{"line": [2, 0, 2, 2], "gaps": [[1.5, 1.0]]}]}, "has an opening from 1.5 to 2.5 m"),
    ({"posters": [{"at": [0, 1], "face": "up"}]}, "posters[0].face must be one of west, east, south, north"),
    ({"light": {"drift": 0.2, "perod": 3}}, "light has no key perod. Did you mean period?"),
    ({"moves": [{"item": "chair", "every": 2, "to": [[1, 1]]}]}, "no piece of furniture is called chair"),
    ({"moves": [{"item": "box", "every": 0, "to": [[1, 1]]}]}, "moves[0] needs every: 1 or more"),
    ({"moves": [{"item": "box", "every": 2, "to": [[0.7, 0.5]]}]}, "puts box at (0.7, 0.5), on the start"),
    ({"moves": [{"item": "box", "every": 2, "to": [[2.5, 1]]}] * 2}, "moves names box more than once"),
    ({"moves": [{"item": "box", "every": 2, "to": [[2.5, 1]]}],
      "furniture": [{"kind": "box", "x": x, "y": 1.6, "name": "box"} for x in (0.4, 1.0)]},
     "moves[0].item: more than one piece of furniture is called box"),
    ({"light": {"drift": 0.2, "period": 0}}, "light.period must be more than 0, not 0"),
    ({"light": {"sigma": -0.1}}, "light.sigma must be 0 or more, not -0.1"),
    ({"light": {"sigma": 10**400}}, "light.sigma must be a number"),
    *(({"furniture": [{"kind": "box", "x": 1, "y": 1, side: size}]},
       f"furniture[0].{side} must be more than 0, not {size}") for side, size in (("w", 0), ("d", -1), ("h", -0.5))),
    ({"posters": [{"at": [0, 1], "face": "east", "width": 0}]}, "posters[0].width must be more than 0"),
    ({"walls": [{"line": [2, 0, 2, 2], "thickness": 0}]}, "walls[0].thickness must be more than 0, not 0"),
    ({"walls": [{"line": [2, 0, 2, 2], "height": -1}]}, "walls[0].height must be 0 or more, not -1"),
    ({"walls": [{"line": [2, 0, 2, 2], "gaps": [[0.1, 0.8], [1.2, -0.1]]}]},
     "walls[0].gaps[1]: its width must be more than 0, not -0.1"),
    ({"walls": [{"line": [2, 0, 2, 2], "windows": [[0.1, 0.0]]}]}, "walls[0].windows[0]: its width"),
    ({"repeat": [{"times": 0, "step": [1, 0], "of": {"kind": "box", "x": 1, "y": 1}}]},
     "repeat[0].times must be more than 0, not 0"),
    *(({key: value}, f"{key} must be a number from") for key in ("height", "camera", "agent_height", "radius", "fov")
      for value in (None, "2", True, float("nan"))),
    ({"start": [2.0, 0.1, 0]}, "the start (2, 0.1) is inside a wall or furniture"),
    ({"start": [9.0, 9.0, 0]}, "The nearest free spot is"),
    ({"start": [0.5, 0.5, 45]}, "degrees a multiple of 10"),
    ({"visitable": 12345}, "promises visitable: 12345 cells and has 3"),
    ({"visitable": 321, "visitable_sha256": "00"}, "not those of visitable_sha256"),
    ({"radius": -1}, "radius must be a number from 0 to 5"),
    ({"radius": 2.0}, "fits nowhere"),
    ({"cell": None}, "needs the side of its coverage cells"),
    ({"cell": 0.07}, "is no whole number of 0.07 m cells"),
    ({"size": None}, "needs a ROS map, env.map=PATH.yaml, or a size"),
    ({"size": [1.0]}, "size must be 2 numbers"),
    ({"camera": 3.0}, "must be below the ceiling"),
    ({"collision": "bounce"}, "collision must be one of cancel, stop, slide"),
])
def test_what_is_refused_is_named(small, change, said: str) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict({**small, **change}, "here.yaml")
    assert said in str(caught.value)
    assert str(caught.value).startswith("here.yaml: ")
    assert "\n" not in str(caught.value)


def test_the_nearest_free_spot_is_free(small) -> None:
    with pytest.raises(SceneError) as caught:
        Scene.from_dict({**small, "start": [2.0, 0.1, 0]})
    x, y = (float(part) for part in str(caught.value).split("(")[-1].rstrip(").").split(","))
    Scene.from_dict({**small, "start": [x, y, 0]})


def test_a_kept_promise_loads_and_another_radius_asks_nothing(small) -> None:
    mask = Scene.from_dict(small).plan.visitable
    promise = {"visitable": int(mask.sum()), "visitable_sha256": fingerprint(mask), "visitable_radius": 0.15}
    assert np.array_equal(Scene.from_dict({**small, **promise}).plan.visitable, mask)
    assert Scene.from_dict({**small, **promise, "radius": 0.2}).plan.visitable.sum() < mask.sum()


def test_tuning_reaches_a_count_exactly(small) -> None:
    count = int(Scene.from_dict(small).plan.visitable.sum())
    tuned = {**small, "tune": {"piece": "box", "axis": "d"}, "visitable": count - 17}
    scene = Scene.from_dict(tuned)
    assert scene.plan.visitable.sum() == count - 17
    assert np.array_equal(Scene.from_dict(tuned).plan.visitable, scene.plan.visitable)
    assert (scene.plan.visitable <= recount(scene)).all()


def test_trimming_keeps_the_rest_in_one_piece() -> None:
    from scipy import ndimage

    mask = np.ones((9, 12), bool)
    mask[4, 1:11] = False
    left = trimmed(mask, (0, 0), 70)
    assert left.sum() == 70 and left[0, 0] and (left <= mask).all()
    assert ndimage.label(left)[1] == 1


MOVES = [{"item": "box", "every": 2, "to": [[1.0, 0.9], [0.4, 1.0]]}]


def test_moved_things_are_recorded_and_stand_in_the_way(small) -> None:
    base = Scene.from_dict({**small, "moves": MOVES})
    places = set()
    for episode in range(12):
        scene, events = base.at(episode, seed=4)
        moved = [event for event in events if event["what"] == "move"]
        assert bool(moved) == (episode % 2 == 0 and episode > 0)
        box = np.flatnonzero(scene.boxes.item == 0)[0]
        centre = tuple(np.round((scene.boxes.low[box] + scene.boxes.high[box])[:2] / 2, 6).tolist())
        places.add(centre)
        if moved:
            assert moved[0]["item"] == "box" and tuple(moved[0]["to"]) == centre != tuple(moved[0]["from"])
        assert (scene.plan.visitable <= base.plan.visitable).all()
        assert np.array_equal(scene.plan.visitable, recount(scene))
    assert places == {(0.4, 1.6), (1.0, 0.9), (0.4, 1.0)}


def test_an_episode_is_a_pure_function_of_seed_and_number(small) -> None:
    small |= {"moves": MOVES, "light": {"drift": 0.4, "sigma": 0.05, "period": 7}}
    base = Scene.from_dict(small)
    late, events = base.at(11, seed=3)
    for episode in range(11):
        base.at(episode, seed=3)
    again, same = Scene.from_dict(small).at(11, 3)
    assert events == same and late.brightness == again.brightness
    assert np.array_equal(late.boxes.low, again.boxes.low)
    levels = [base.at(episode, 3)[0].brightness for episode in range(30)]
    assert 0.2 <= min(levels) < 0.75 and 0.9 < max(levels) <= 1.0
    assert base.at(5, 1)[0].brightness != base.at(5, 2)[0].brightness


def test_changes_are_switched_off_by_one_key(small) -> None:
    scene = Scene.from_dict({**small, "moves": MOVES, "light": {"drift": 0.4}, "changes": False})
    assert scene.at(7, 0) == (scene, ())
    assert scene.at(7, 0)[0] is scene


def test_repeat_writes_out_a_row(small) -> None:
    row = {"times": 3, "step": [0.5, 0.0], "of": {"kind": "bin", "x": 0.3, "y": 1.2, "name": "bin"}}
    more = Scene.from_dict({**small, "repeat": [row]}).boxes
    assert len(more) == len(Scene.from_dict(small).boxes) + 3


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_stands_on_the_floor_within_its_size(kind: str) -> None:
    entry = KINDS[kind]
    parts = entry.parts(entry.w, entry.d, entry.h, entry.material)
    assert exists(entry.material)
    assert (min(part[4] for part in parts) == 0) if parts else kind == "rug"
    for x0, x1, y0, y1, z0, z1, material, _ in parts:
        assert -1e-9 <= x0 < x1 <= entry.w + 1e-9 and -1e-9 <= y0 < y1 <= entry.d + 1e-9
        assert 0 <= z0 < z1 and exists(material)
