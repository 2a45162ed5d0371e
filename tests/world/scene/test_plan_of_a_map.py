"""The floor plan of a ROS map: drawn from the map's cells, so that no obstacle looks free and unknown is no wall."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from curionav_cli.records import FloorPlan, Pose
from curionav_cli.world.contact_sheet import MIST, top_view
from curionav_cli.world.scene.ground import highest
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

FREE, WALL, UNKNOWN = 254, 0, 205


def opened(folder: Path, pixels: np.ndarray, more: str = "", **changes) -> Scene:
    """The map of these pixels, row 0 on top, 5 cm each; grey 205 is unknown."""
    cv2.imwrite(str(folder / "map.png"), pixels.astype(np.uint8))
    (folder / "map.yaml").write_text("image: map.png\nresolution: 0.05\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n"
                                     f"occupied_thresh: 0.65\nfree_thresh: 0.19\n{more}")
    return Scene.from_dict(*plain("map", map=str(folder / "map.yaml"), **changes))


def test_the_rock_around_a_bent_corridor_is_solid_to_its_last_cell(tmp_path: Path) -> None:
    pixels = np.full((300, 260), WALL)
    pixels[40:280, 30:50], pixels[260:280, 30:230] = FREE, FREE  # 240 and 200 cells long, 20 wide, a common corner
    plan = opened(tmp_path, pixels).plan
    assert plan.solid.sum() == 300 * 260 - (240 + 200 - 20) * 20 == (pixels == WALL).sum()
    np.testing.assert_array_equal(plan.solid, (pixels == WALL)[::-1])


def test_a_thick_pillar_has_no_hole_and_the_inside_of_a_ring_is_no_floor(tmp_path: Path) -> None:
    y, x = np.mgrid[:200, :200] - 100.0
    away = np.hypot(x, y)
    pixels = np.where((away < 60) & (away > 30), WALL, FREE)
    plan = opened(tmp_path, pixels).plan
    np.testing.assert_array_equal(plan.solid, (pixels == WALL)[::-1])
    inside = (away <= 30)[::-1]
    assert not plan.floor[inside].any() and (plan.occupancy[inside] == 0).all()


def test_unknown_space_differs_from_walls_and_is_kept_in_the_runs_plan(tmp_path: Path) -> None:
    pixels = np.full((80, 100), UNKNOWN)
    pixels[10:70, 10:90], pixels[12:68, 12:88] = WALL, FREE
    plan = opened(tmp_path, pixels, dock=[1.0, 1.0, 90]).plan
    np.testing.assert_array_equal(plan.unknown, (pixels == UNKNOWN)[::-1])
    assert not (plan.unknown & plan.solid).any() and plan.solid.sum() == (pixels == WALL).sum()
    plan.save(tmp_path / "plan.npz")
    back = FloorPlan.load(tmp_path / "plan.npz")
    np.testing.assert_array_equal(back.occupancy, plan.occupancy)
    assert back.dock == Pose(1.0, 1.0, pytest.approx(np.pi / 2)) and back.map_origin == Pose(-1.0, 2.0, 0.0)


def test_glass_keeps_its_value(tmp_path: Path) -> None:
    """Mode scale: grey 140 is between free and occupied."""
    pixels = np.full((60, 60), FREE)
    pixels[30, :], pixels[:, 0] = 140, WALL
    plan = opened(tmp_path, pixels, "mode: scale\n").plan
    assert len(np.unique(plan.occupancy)) == 3 and ((plan.occupancy[29, 1:] > 0) & (plan.occupancy[29, 1:] < 100)).all()


def test_a_thin_wall_is_in_the_plan_of_wider_cells_too(tmp_path: Path) -> None:
    pixels = np.full((61, 90), FREE)
    pixels[:, 41] = WALL
    plan = opened(tmp_path, pixels, cell=0.15).plan
    assert plan.solid.shape == (20, 30) and plan.solid[:, 13].all() and plan.solid.sum() == 20


def test_the_highest_value_of_finer_wider_and_uneven_cells() -> None:
    cells = np.array([[-1, 0, 100], [0, -1, -1]], np.int8)
    assert highest(cells, 1.0, (2, 3), 1.0).tolist() == cells.tolist()
    assert highest(cells, 1.0, (4, 6), 0.5).tolist() == np.kron(cells, np.ones((2, 2))).tolist()
    assert highest(cells, 1.0, (1, 2), 2.0).tolist() == [[0, 100]]
    assert highest(cells, 1.0, (1, 2), 1.5).tolist() == [[0, 100]]


def test_a_scene_without_a_map_has_nothing_unknown(small_room: Scene) -> None:
    assert small_room.plan.occupancy is None and not small_room.plan.unknown.any() and small_room.plan.solid.any()


def test_the_top_view_shows_the_corner_that_nobody_saw_as_unknown(tmp_path: Path) -> None:
    pixels = np.full((100, 100), UNKNOWN)
    for color, edge in ((WALL, 0), (FREE, 1)):
        pixels[10 + edge:90 - edge, 10 + edge:40 - edge] = pixels[60 + edge:90 - edge, 10 + edge:90 - edge] = color
    image = top_view(opened(tmp_path, pixels), 400)
    corner = image[:200, 200:-6]  # beyond the arms
    assert (corner == MIST).all(-1).mean() > 0.95
