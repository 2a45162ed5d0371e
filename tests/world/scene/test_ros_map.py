"""ROS maps: golden values of the loader, its traps, every wrong input, and real maps where they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mapmaking import HEAD, write_map
from scipy import ndimage

from curionav_cli.errors import MapError, SceneError
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.map_furnishing import rooms
from curionav_cli.world.scene.rectangle_cover import cover
from curionav_cli.world.scene.ros_map import FREE, OCCUPIED, read_map
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain


def house(rows: int = 30, columns: int = 40) -> np.ndarray:
    """Two rooms with a door between them, grey unknown around."""
    pixels = np.full((rows, columns), 205)
    pixels[2:-2, 2:-2] = 0
    pixels[3:-3, 3:-3] = 254
    pixels[:, 20] = np.where(pixels[:, 20] == 254, 0, pixels[:, 20])
    pixels[12:20, 20] = 254
    return pixels


def open_house(tmp_path: Path, pixels: np.ndarray, more: str = "negate: 0\n", **changes) -> Scene:
    return Scene.from_dict(*plain("map", map=str(write_map(tmp_path, pixels, more)), radius=0.15, **changes))


def test_the_transform_is_kept_and_the_world_is_in_image_axes(tmp_path: Path) -> None:
    scene = open_house(tmp_path, house())
    assert scene.plan.map_origin == (-1.0, 2.0, 0.3)
    assert scene.size == pytest.approx((4.0, 3.0)) and scene.plan.cell == 0.1
    assert np.array_equal(scene.plan.floor, house()[::-1] == 254)


def test_visitable_cells_keep_the_radius_from_every_solid_square(tmp_path: Path) -> None:
    scene = open_house(tmp_path, house())
    solid = ndimage.distance_transform_edt(np.pad(house()[::-1] == 254, 1))[1:-1, 1:-1]
    assert not scene.plan.visitable[solid * 0.1 - 0.05 <= 0.15 - 1e-9].any()
    row, column = scene.plan.cells(scene.plan.start.x, scene.plan.start.y)
    assert scene.plan.visitable[row, column]
    assert scene.plan.visitable[:, :18].any() and scene.plan.visitable[:, 23:].any()


def test_only_the_part_of_the_start_is_kept_and_it_is_sealed(tmp_path: Path) -> None:
    pixels = house()
    pixels[:, 20] = np.where(pixels[:, 20] == 254, 0, pixels[:, 20])
    largest = open_house(tmp_path, pixels).plan
    assert not largest.visitable[:, 20:].any() or not largest.visitable[:, :20].any()
    right = open_house(tmp_path, pixels, start=[3.0, 1.5, 90]).plan
    assert right.visitable[:, 21:].any() and not right.floor[:, :20].any()


def test_coverage_cells_may_be_coarser(tmp_path: Path) -> None:
    scene = open_house(tmp_path, house(), cell=0.2)
    assert scene.plan.visitable.shape == (15, 20)
    assert scene.plan.visitable.any()


def test_furniture_and_posters_may_be_added_to_a_map(tmp_path: Path) -> None:
    bare = open_house(tmp_path, house())
    more = open_house(tmp_path, house(), furniture=[{"kind": "cabinet", "x": 1.0, "y": 1.5}])
    assert more.plan.visitable.sum() < bare.plan.visitable.sum()
    assert len(more.boxes) == len(bare.boxes) + 1


def wrong(tmp_path: Path, text: str) -> Path:
    write_map(tmp_path, house())
    path = tmp_path / "map.yaml"
    path.write_text(text)
    return path


GOOD = HEAD.format(image="map.pgm") + "negate: 0\n"


@pytest.mark.parametrize(("text", "said"), [
    (GOOD.replace("map.pgm", "gone.pgm"), "its image .*gone.pgm does not exist, and no gone.pgm is beside"),
    (GOOD.replace("-1.0", ".nan"), "origin must be a number, not nan"),
    (GOOD.replace("[-1.0, 2.0, 0.3]", "here"), "origin must be \\[x, y, yaw\\]"),
    (GOOD.replace("resolution: 0.1", "resolution: 0"), "resolution is 0; it is metres per pixel"),
    (GOOD.replace("resolution: 0.1", "resolution: fine"), "resolution must be a number"),
    (GOOD.replace("0.65", "65"), "occupied_thresh is 65; it is a share, at most 1. Write 65 per cent as 0.65"),
    (GOOD.replace("0.196", "25"), "free_thresh is 25; it is a share, at most 1"),
    (GOOD.replace("0.196", "{}"), "free_thresh must be a number"),
    (GOOD.replace("0.65", ".inf"), "occupied_thresh must be a number, not inf"),
    (GOOD.replace("resolution: 0.1", "resolution: -0.1"), "resolution is -0.1; it is metres per pixel"),
    (GOOD.replace("resolution: 0.1", "resolution: 0.1 m"), "resolution must be a number, not '0.1 m'"),
    (GOOD.replace("negate: 0", "negate: perhaps"), "negate must be 0 or 1, true or false, not 'perhaps'"),
    (GOOD.replace("map.pgm", "[map.pgm]"), "image must be the name of a file"),
    (GOOD + "mode: fancy\n", "mode must be trinary, scale or raw"),
    (GOOD.replace("negate: 0", "negate: 1"), "the map has no free cell|nothing to explore"),
    ("just a sentence", "is no ROS map: it lacks image, resolution, origin"),
    ("image: map.pgm\nresolution: 0.1\n", "is no ROS map: it lacks origin"),
    ("a: [1,\n b: {", "is not YAML"),
])
def test_wrong_maps_are_refused_in_one_line(tmp_path: Path, text: str, said: str) -> None:
    path = wrong(tmp_path, text)
    if "negate: 1" in text:
        (tmp_path / "map.pgm").write_bytes(b"P5\n3 3\n255\n" + bytes([254] * 9))
    with pytest.raises(MapError, match=said) as caught:
        Scene.from_dict(*plain("map", map=str(path)))
    assert "\n" not in str(caught.value) and str(tmp_path) in str(caught.value)


def test_files_that_are_no_map(tmp_path: Path) -> None:
    path = write_map(tmp_path, house())
    with pytest.raises(MapError, match=r"is an image\. Give the map's YAML file"):
        Scene.from_dict(*plain("map", map=str(tmp_path / "map.pgm")))
    with pytest.raises(MapError, match="There is no map"):
        Scene.from_dict(*plain("map", map=str(tmp_path / "other.yaml")))
    (tmp_path / "map.pgm").write_bytes(b"P5\n40 30\n255\n" + bytes(20))
    with pytest.raises(MapError, match="is cut off or no PGM"):
        Scene.from_dict(*plain("map", map=str(path)))
    (tmp_path / "map.pgm").write_bytes(b"not a picture")
    with pytest.raises(MapError, match="is no image that can be read"):
        Scene.from_dict(*plain("map", map=str(path)))
    with pytest.raises(SceneError, match=r"needs a ROS map, env\.map=PATH\.yaml"):
        Scene.from_dict(*plain("map"))


def test_the_edge_of_the_image_is_a_wall_that_is_seen(tmp_path: Path) -> None:
    path = write_map(tmp_path, np.full((60, 80), 254))
    path.write_text(path.read_text().replace("resolution: 0.1", "resolution: 0.05"))
    scene = Scene.from_dict(*plain("map", map=str(path), radius=0.15))
    assert scene.size == (4.0, 3.0) and scene.plan.floor.all() and not scene.plan.solid.any()
    assert scene.plan.visitable.sum() == (60 - 6) * (80 - 6)
    renderer = Renderer(scene)
    for heading, away in ((0, 4.0 - 1.3), (9, 3.0 - 1.1), (18, 1.3), (27, 1.1)):
        seen = renderer.render(1.3, 1.1, heading)[1][0, 31:33, 31:33]
        assert seen == pytest.approx(np.full((2, 2), away), abs=0.01)
    whole = renderer.render(np.full(36, 1.3), np.full(36, 1.1), np.arange(36))[1]
    assert whole.max() < 5.0, "no gap in a corner"


@pytest.mark.parametrize("start", [[], [1], [float("nan"), 1, 0], ["a", "b", 0], 5, [1, 1, 45]])
def test_a_start_that_is_no_pose_is_refused_before_the_map_is_searched(tmp_path: Path, start) -> None:
    with pytest.raises(SceneError, match=r"start must be (\[x, y, degrees\]|a list of numbers)") as caught:
        open_house(tmp_path, house(), start=start)
    assert "\n" not in str(caught.value)


def test_a_robot_too_wide_is_refused(tmp_path: Path) -> None:
    path = write_map(tmp_path, house())
    with pytest.raises(SceneError, match="of radius 3 m fits nowhere"):
        Scene.from_dict(*plain("map", map=str(path), radius=3.0))


def test_a_mesh_covers_every_wall_that_is_seen_and_no_floor() -> None:
    solid = ndimage.gaussian_filter(np.random.default_rng(0).normal(size=(60, 70)), 2) > 0
    covered = np.zeros_like(solid)
    boxes = cover(solid, 12)
    for r0, c0, r1, c1 in boxes:
        assert 0 < r1 - r0 <= 12 and 0 < c1 - c0 <= 12
        covered[r0:r1, c0:c1] = True
    beside = ndimage.binary_dilation(~solid, np.ones((3, 3))) & solid
    assert (covered >= beside).all() and not (covered & ~solid).any()
    assert len(boxes) < beside.sum() / 3


def test_rooms_are_separated_by_their_door() -> None:
    free = house() == 254
    number = rooms(free, 0.1)
    assert (number >= 0).tolist() == free.tolist()
    assert number[15, 8] != number[15, 30]


REAL = {
    "ipa-apartment/map.yaml": 278, "strands_kth/map.yaml": 357, "fetch_9_16_15/9_16_15.yaml": 770,
    "aws_small_house/map.yaml": 155, "tb3_world/map.yaml": 20,
}


@pytest.mark.ros
@pytest.mark.parametrize("name", REAL)
def test_real_maps_open_and_are_drawn(real_maps: Path, name: str, draw_spots) -> None:
    scene = Scene.from_dict(*plain("map", map=str(real_maps / name)))
    assert scene.plan.floor.sum() * 0.0025 == pytest.approx(REAL[name], rel=0.12)
    assert scene.plan.visitable.sum() > 0.6 * scene.plan.floor.sum()
    assert (scene.plan.visitable <= scene.plan.floor).all()
    rgb, depth = Renderer(scene).render(*draw_spots(scene, 24, 0))
    assert depth.min() > 0.05 and rgb.std(axis=(1, 2, 3)).min() > 5


@pytest.mark.ros
def test_real_fixtures_of_nav2(real_maps: Path) -> None:
    folder = real_maps / "nav2_testmaps"
    ros = read_map(folder / "testmap.yaml")
    assert ros.origin == (2.0, 3.0, 1.0) and ros.cells.shape == (10, 10)
    assert (ros.cells == FREE).sum() == 71 and (ros.cells == OCCUPIED).sum() == 29
    assert read_map(folder / "map_circular.yaml").cells.shape == (384, 384)
    ten = read_map(folder / "TenByTen.yaml")
    assert ten.resolution == 1.0 and (ten.cells == FREE).sum() == 78
    with pytest.raises(MapError, match="is an image"):
        Scene.from_dict(*plain("map", map=str(real_maps / "tb3_office" / "map_office.pgm")))
