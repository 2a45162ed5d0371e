"""What the greys of a map mean: thresholds, modes, and what is taken for a key that is missing. Grids written out."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mapmaking import HEAD, describe, drawn, write_map

from curionav_cli.errors import SceneError
from curionav_cli.world.scene.ros_map import FREE, OCCUPIED, UNKNOWN, MapWarning, read_map
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

GREYS = np.array([[0, 89, 90, 127], [204, 205, 206, 254]])  # p: 1, .651, .647, .502 / .2, .196, .192, .004


def thresholds(occupied: str, free: str, more: str = "negate: 0\n") -> str:
    return HEAD.format(image="map.pgm").replace("0.65", occupied).replace("0.196", free) + more


def test_trinary_greys_and_the_flip(tmp_path: Path) -> None:
    cells = read_map(write_map(tmp_path, GREYS)).cells
    assert cells.tolist() == [[UNKNOWN, UNKNOWN, FREE, FREE], [OCCUPIED, OCCUPIED, UNKNOWN, UNKNOWN]]


def test_negate_turns_black_and_white_over(tmp_path: Path) -> None:
    assert drawn(write_map(tmp_path, GREYS)) == ["##??", "??.."]
    assert drawn(write_map(tmp_path, 255 - GREYS, "negate: 1\n")) == ["##??", "??.."]


@pytest.mark.parametrize(("occupied", "free", "greys", "cells"), [
    ("0.6", "0.196", [101, 102, 103], "##?"),  # 1 - 102/255 is 0.6, in float32 as well
    ("0.65", "0.2", [203, 204, 206], "?.."),
    ("1.0", "0.0", [0, 1, 254, 255], "#??."),  # black and white make a map
    ("0.5", "0.5", [126, 127, 128, 129], "##.."),
    ("0.3", "0.7", [0, 76, 77, 128, 178, 179, 255], "##....."),  # free wins where both hold
    ("0.65", "-0.1", [0, 128, 255], "#??"),
])
def test_a_threshold_belongs_to_what_it_bounds(tmp_path: Path, occupied: str, free: str, greys: list[int],
                                               cells: str) -> None:
    write_map(tmp_path, np.array([greys]))
    assert drawn(describe(tmp_path, thresholds(occupied, free))) == [cells]


@pytest.mark.parametrize("mode", ["trinary", "Trinary", "TRINARY", '"trinary"'])
def test_a_mode_in_any_case(tmp_path: Path, mode: str) -> None:
    assert drawn(write_map(tmp_path, GREYS, f"negate: 0\nmode: {mode}\n")) == ["##??", "??.."]


def test_scale_and_raw(tmp_path: Path) -> None:
    greys = np.where(GREYS == 205, 203, GREYS)
    scale = read_map(write_map(tmp_path, greys, "mode: SCALE\nnegate: 0\n")).cells
    assert scale.tolist() == [[1, 2, 0, 0], [100, 100, 99, 67]]  # p 0.2, 0.204: 0.86 and 1.73 of 100, rounded
    raw = read_map(write_map(tmp_path, np.array([[0, 40, 100, 101, 200, 255]]), "mode: Raw\nnegate: 1\n")).cells
    assert raw.tolist() == [[0, 40, 100, UNKNOWN, UNKNOWN, UNKNOWN]]


def glass(tmp_path: Path) -> Path:
    """A room of 3 x 2 m, white; in its middle, from wall to wall, a pane of grey 128: in scale 67 of 100."""
    pixels = np.full((22, 32), 0)
    pixels[1:-1, 1:-1] = 254
    pixels[1:-1, 16] = 128
    return write_map(tmp_path, pixels, "mode: scale\nnegate: 0\n")


@pytest.mark.parametrize(("value", "open_there"), [(100, True), (68, True), (67, False), (1, False)])
def test_from_which_value_on_a_cell_is_a_wall(tmp_path: Path, value: int, open_there: bool) -> None:
    path = glass(tmp_path)
    assert read_map(path).cells[10, 16] == 67
    plan = Scene.from_dict(*plain("map", map=str(path), radius=0.15, scale_occupied=value)).plan
    assert plan.floor[10, 16] == open_there and plan.visitable[:, 16].any() == open_there
    assert plan.floor.any(axis=0)[[5, 27]].all() == open_there


def test_nav2s_costmap_is_the_default(tmp_path: Path) -> None:
    assert Scene.from_dict(*plain("map", map=str(glass(tmp_path)))).plan.floor[10, 16]
    with pytest.raises(SceneError, match="scale_occupied must be a number from 1 to 100, not 0"):
        Scene.from_dict(*plain("map", map=str(glass(tmp_path)), scale_occupied=0))


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    write_map(tmp_path, GREYS)
    with pytest.warns(MapWarning, match=r"lacks negate, which Nav2 refuses\. Taken for it: negate 0\."):
        assert drawn(describe(tmp_path, HEAD.format(image="map.pgm"))) == ["##??", "??.."]
    bare = "image: map.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\nfree_thresh:\n"
    with pytest.warns(MapWarning, match=r"lacks occupied_thresh and free_thresh.* 0\.65, free_thresh 0\.196"):
        assert drawn(describe(tmp_path, bare)) == ["##??", "??.."]


def test_the_grey_of_unknown_is_warned_of_and_mended(tmp_path: Path) -> None:
    write_map(tmp_path, np.array([[205, 254, 0, 205]]))
    path = describe(tmp_path, thresholds("0.65", "0.25"))
    with pytest.warns(MapWarning, match=r"env\.unknown_grey=205"):
        assert drawn(path) == ["..#."]
    assert read_map(path, unknown_grey=205).cells.tolist() == [[UNKNOWN, FREE, OCCUPIED, UNKNOWN]]


@pytest.mark.parametrize(("free", "value"), [("0.19", 1), ("0.196", 0)])
def test_in_mode_scale_it_is_warned_of_too(tmp_path: Path, free: str, value: int) -> None:
    write_map(tmp_path, np.array([[205, 254, 0, 205]]))
    path = describe(tmp_path, thresholds("0.65", free, "negate: 0\nmode: scale\n"))
    with pytest.warns(MapWarning, match=r"with mode scale it is free\. Set env\.unknown_grey=205"):
        assert read_map(path).cells.tolist() == [[value, FREE, OCCUPIED, value]]
    assert read_map(path, unknown_grey=205).cells.tolist() == [[UNKNOWN, FREE, OCCUPIED, UNKNOWN]]


@pytest.mark.parametrize(("resolution", "columns", "warned"), [
    ("0.013", 30, True), ("0.013", 20, False), ("0.0125", 90, False), ("0.050", 400, False), ("0.025000", 90, False),
    ("1.3e-2", 90, False)])
def test_a_resolution_that_a_saver_rounded(tmp_path: Path, resolution: str, columns: int, warned: bool) -> None:
    write_map(tmp_path, np.full((2, columns), 254))
    path = describe(tmp_path, thresholds("0.65", "0.196").replace("resolution: 0.1", f"resolution: {resolution}"))
    if not warned:
        assert read_map(path).resolution == float(resolution)
        return
    with pytest.warns(MapWarning, match=r"resolution 0\.013 has three decimals.* over 30 pixels that may be 0\.015 m"):
        assert read_map(path).resolution == 0.013


@pytest.mark.parametrize("named", ["maps/gone/map.pgm", "/home/robot/maps/map.pgm", "C:\\maps\\map.pgm", "../map.pgm"])
def test_an_image_of_another_machine_lies_beside_the_yaml(tmp_path: Path, named: str) -> None:
    write_map(tmp_path, GREYS)
    with pytest.warns(MapWarning, match=r"its image .* does not exist; .*map\.pgm is taken for it"):
        assert drawn(describe(tmp_path, HEAD.format(image=named) + "negate: 0\n")) == ["##??", "??.."]


def test_an_image_in_a_folder_that_exists_is_taken_from_there(tmp_path: Path) -> None:
    write_map(tmp_path, 0 * GREYS)
    (tmp_path / "images").mkdir()
    write_map(tmp_path / "images", GREYS)
    assert drawn(describe(tmp_path, HEAD.format(image="images/map.pgm") + "negate: 0\n")) == ["##??", "??.."]
    whole = tmp_path / "images" / "map.pgm"
    assert drawn(describe(tmp_path, HEAD.format(image=whole) + "negate: 0\n")) == ["##??", "??.."]


def test_maps_of_cartographer_and_slam_toolbox(tmp_path: Path) -> None:
    """cartographer's greys are probabilities, 128 unknown; slam_toolbox writes an image with a folder's name."""
    write_map(tmp_path, np.array([[128, 200, 206, 240, 255], [128, 100, 89, 30, 0]]))
    assert drawn(describe(tmp_path, thresholds("0.65", "0.196"))) == ["??...", "??###"]
    write_map(tmp_path, np.array([[205, 254, 0]]), name="office.pgm")
    text = ("image: maps/office.pgm\nmode: trinary\nresolution: 0.05\norigin: [-2.51, -7.04, 0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.25\n")
    with pytest.warns(MapWarning) as caught:
        assert drawn(describe(tmp_path, text)) == ["..#"]
    assert [str(each.message).split(": ")[1].split()[0] for each in caught] == ["its", "grey"]
