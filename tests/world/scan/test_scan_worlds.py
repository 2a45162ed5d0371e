"""Scans as worlds: formats, axes, units, tilt, storeys, holes, what can be stepped over, and how they are used."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from meshmaking import box, quad, room, write_obj, write_ply, write_quads, write_stl, y_up

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.reader import GREY
from curionav_cli.world.scan.upright import levelling
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

trimesh = pytest.importorskip("trimesh", reason="the extra scan is not installed")
pytest.importorskip("embreex", reason="the extra scan is not installed")

ROOM = room()


def scan(path: Path, **settings: Any) -> Scene:
    return Scene.from_dict(*plain("scan", mesh=str(path), **{"cell": 0.1, **settings}))


def write_glb(path: Path, triangles: np.ndarray) -> Path:
    places = y_up(triangles).reshape(-1, 3)
    mesh = trimesh.Trimesh(places, np.arange(len(places)).reshape(-1, 3), process=False)
    path.write_bytes(trimesh.Scene(mesh).export(file_type="glb"))
    return path


@pytest.fixture
def a_room(tmp_path: Path) -> Path:
    return write_ply(tmp_path / "room.ply", ROOM)


def test_the_cells_of_a_room_can_be_counted(a_room: Path) -> None:
    """Free of a wall is what is farther than 0.1 m: the second cell from it on, of 40 x 30."""
    plan = scan(a_room).plan
    blocked = [(row, column) for row in range(8) for column in range(12) if np.hypot(
        max(0.0, (column + 0.5) / 10 - 1.0), max(0.0, (row + 0.5) / 10 - 0.6)) <= 0.1 + 2e-4]
    inner = [(row, column) for row, column in blocked if row >= 1 and column >= 1]
    assert plan.visitable.sum() == 38 * 28 - len(inner)


@pytest.mark.parametrize("write", [write_stl, lambda path, held: write_obj(path, y_up(held)), write_glb, write_quads],
                         ids=["stl", "obj", "glb", "quads"])
def test_every_format_gives_the_same_cells(a_room: Path, write) -> None:
    name = {write_stl: "other.stl", write_glb: "other.glb", write_quads: "other.ply"}.get(write, "other.obj")
    assert np.array_equal(scan(write(a_room.with_name(name), ROOM)).plan.visitable, scan(a_room).plan.visitable)


def test_colours_are_those_of_the_corners_and_grey_without(a_room: Path, tmp_path: Path) -> None:
    env = gymnasium.make("curionav/Scan-v0", mesh=str(a_room))
    check_env(env.unwrapped, skip_render_check=True)
    image = env.reset(seed=0)[0]["image"]
    assert set(map(tuple, image.reshape(-1, 3).tolist())) <= {(200, 40, 40), (188, 192, 196)}
    grey = scan(write_stl(tmp_path / "grey.stl", ROOM)).plan.picture
    assert grey.shape[-1] == 3 and np.all(grey[len(grey) // 2, grey.shape[1] // 2] == GREY)


@pytest.mark.parametrize("up", ["x", "y", "z", "-x", "-y", "-z"])
def test_any_axis_may_point_up(a_room: Path, tmp_path: Path, up: str) -> None:
    from curionav_cli.world.scan.mesh import AXES

    turned = write_ply(tmp_path / "turned.ply", ROOM @ np.array(AXES[up], float))
    assert np.array_equal(scan(turned, up=up).plan.visitable, scan(a_room).plan.visitable)


def test_triangles_may_face_either_way(a_room: Path, tmp_path: Path) -> None:
    flipped = ROOM.copy()
    some = np.random.default_rng(0).random(len(ROOM)) < 0.5
    flipped[some] = flipped[some][:, ::-1]
    assert np.array_equal(scan(write_ply(tmp_path / "flipped.ply", flipped)).plan.visitable,
                          scan(a_room).plan.visitable)


def test_millimetres_are_named_and_scaled(a_room: Path, tmp_path: Path) -> None:
    large = write_ply(tmp_path / "large.ply", 1000 * ROOM)
    with pytest.raises(SceneError, match=r"env\.scale=0\.001"):
        scan(large)
    assert np.array_equal(scan(large, scale=0.001).plan.visitable, scan(a_room).plan.visitable)


def test_a_tilt_is_taken_out(a_room: Path, tmp_path: Path) -> None:
    up = np.array([np.sin(0.07), 0.0, np.cos(0.07)])
    tilted = scan(write_ply(tmp_path / "tilted.ply", ROOM @ levelling(up)))
    assert any("a tilt of 4.0 degrees" in line for line in tilted.view.about)
    assert abs(int(tilted.plan.visitable.sum()) / int(scan(a_room).plan.visitable.sum()) - 1) < 0.05


def test_storeys_are_counted_from_the_lowest(tmp_path: Path) -> None:
    house = write_ply(tmp_path / "house.ply", np.concatenate([room(0.0), room(2.6, 3.0), quad(
        (0, 0, 5.2), (3.0, 0, 0), (0, 3.0, 0))]))
    below, above = scan(house), scan(house, storey=1)
    assert below.plan.visitable.sum() > above.plan.visitable.sum() > 100
    assert np.array_equal(scan(house, level=2.6).plan.visitable, above.plan.visitable)
    with pytest.raises(SceneError, match=r"no storey 2\. There is 0: 0\.00 m, 1: 2\.60 m\."):  # a roof is no floor
        scan(house, storey=2)


def test_of_a_slab_the_top_is_the_floor(tmp_path: Path, a_room: Path) -> None:
    slab = np.concatenate([ROOM, quad((0, 0, -0.2), (4, 0, 0), (0, 3, 0)), quad((0, 0, -0.2), (4, 0, 0), (0, 0, 0.2))])
    assert np.array_equal(scan(write_ply(tmp_path / "slab.ply", slab)).plan.visitable, scan(a_room).plan.visitable)


def test_a_hole_is_a_wall_and_is_named(tmp_path: Path, a_room: Path) -> None:
    holed = np.delete(ROOM, [10, 26], axis=0)  # one of the 16 squares of the floor, 1 x 0.75 m
    scene = scan(write_ply(tmp_path / "holed.ply", holed))
    assert any(line.startswith("1 hole in the scanned floor, 0.7") for line in scene.view.about)
    assert scan(a_room).plan.visitable.sum() - scene.plan.visitable.sum() >= 70


def test_what_is_lower_than_a_step_is_floor(tmp_path: Path, a_room: Path) -> None:
    for height, counts in ((0.02, True), (0.05, False)):
        held = np.concatenate([ROOM, box((2, 1, 0), (3, 2, height))])
        cells = scan(write_ply(tmp_path / "step.ply", held)).plan.visitable.sum()
        assert bool(cells == scan(a_room).plan.visitable.sum()) is counts
    assert scan(tmp_path / "step.ply", step=0.06).plan.visitable.sum() == scan(a_room).plan.visitable.sum()


def test_what_is_steeper_than_the_slope_is_no_floor(tmp_path: Path) -> None:
    ripples = room()
    ripples[:32, :, 2] += 0.02 * (np.round(ripples[:32, :, 0]) % 2)  # a rise of 2 cm in a metre: 1.1 degrees
    path = write_ply(tmp_path / "ripples.ply", ripples)
    assert scan(path).plan.visitable.sum() > 900
    with pytest.raises(SceneError):
        scan(path, slope=1.0)


def test_what_is_higher_than_the_robot_is_passed_under(tmp_path: Path, a_room: Path) -> None:
    board = np.concatenate([ROOM, box((2, 1, 0.5), (3, 2, 0.6))])
    path = write_ply(tmp_path / "board.ply", board)
    assert scan(path).plan.visitable.sum() == scan(a_room).plan.visitable.sum()
    assert scan(path, agent_height=0.6).plan.visitable.sum() < scan(a_room).plan.visitable.sum()


def test_start_counts_in_the_axes_of_the_file(a_room: Path) -> None:
    scene = scan(a_room, start=[2.55, 1.55, 90])
    origin = scene.plan.map_origin
    assert scene.plan.start[:2] == pytest.approx((2.55 - origin.x, 1.55 - origin.y))
    with pytest.raises(SceneError, match=r"the start \(0\.05, 1\.5\) is inside"):
        scan(a_room, start=[0.05, 1.5, 0])


@pytest.mark.parametrize(("settings", "words"), [
    ({"up": "w"}, "env.up must be one of"), ({"step": 0.6}, "env.step"), ({"slope": 80.0}, "env.slope"),
    ({"haze": 2.0}, "env.haze"), ({"storey": -1}, "env.storey"), ({"scale": 0.0}, "env.scale"),
    ({"furniture": [{"kind": "box", "x": 1, "y": 1}]}, "env.furniture"), ({"radius": 3.0}, "fits nowhere"),
    ({"counted": 0}, "env.counted"), ({"level": 9.0}, "Nothing of it is"), ({"mesh": None}, "env.mesh"),
])
def test_settings_that_do_not_go_are_answered(a_room: Path, settings: dict[str, Any], words: str) -> None:
    with pytest.raises(SceneError, match=words):
        scan(**{"path": a_room, **settings}) if "mesh" not in settings else Scene.from_dict(*plain("scan"))


def test_numba_draws_boxes_only(a_room: Path) -> None:
    with pytest.raises(SceneError, match=r"Set env\.engine=numpy"):
        gymnasium.make("curionav/Scan-v0", mesh=str(a_room), engine="numba")


def test_vector_worlds_see_what_one_world_sees(a_room: Path) -> None:
    one = gymnasium.make("curionav/Scan-v0", mesh=str(a_room), collision="slide")
    many = gymnasium.make_vec("curionav/Scan-v0", num_envs=3, mesh=str(a_room), collision="slide")
    seen, (batch, _) = one.reset(seed=0)[0], many.reset(seed=0)
    for action in (0, 1, 0, 0, 2, 0, 0):
        assert all(np.array_equal(batch[key][1], seen[key]) for key in seen)
        seen, batch = one.step(action)[0], many.step(np.full(3, action))[0]
    assert seen["depth"].dtype == np.float32 and seen["depth"].min() > 0.0


@pytest.mark.parametrize("size", [64, 128])
def test_depth_is_that_of_the_walls(a_room: Path, size: int) -> None:
    scene = scan(a_room, start=[2.05, 1.55, 0])
    env = gymnasium.make("curionav/Scan-v0", mesh=str(a_room), cell=0.1, start=[2.05, 1.55, 0], size=size)
    depth, part = env.reset()[0]["depth"], size // 64
    assert scene.start_heading == 0 and depth.shape == (size, size)
    assert depth[30 * part, 20 * part:44 * part] == pytest.approx(np.full(24 * part, 1.95), abs=1e-4)
