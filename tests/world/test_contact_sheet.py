"""The contact sheet: a picture of the whole scene."""

from __future__ import annotations

from pathlib import Path

import cv2

from curionav_cli.world.contact_sheet import contact_sheet, plans, top_view
from curionav_cli.world.scene.scene import Scene


def test_a_sheet_shows_plan_views_and_depths(small_room: Scene, tmp_path: Path) -> None:
    path = tmp_path / "sheet.png"
    contact_sheet(small_room, path)
    image = cv2.imread(str(path))
    assert image.shape[0] > 500 and image.shape[1] > 1000
    assert len({pixel.tobytes() for pixel in image[::7, ::7].reshape(-1, 3)}) > 1000
    contact_sheet(small_room, tmp_path / "again.png")
    assert (tmp_path / "again.png").read_bytes() == path.read_bytes()


def test_the_top_view_is_upright(small) -> None:
    """The box stands in the north-west: left and above the middle of the picture."""
    small["furniture"] = [{"kind": "toolbox", "x": 0.4, "y": 1.6, "w": 0.5, "d": 0.5}]
    image = top_view(Scene.from_dict(small), 300).astype(int)
    red = (image[..., 0] > 120) & (image[..., 1] < 90) & (image[..., 2] < 90)
    rows, columns = red.nonzero()
    assert len(rows) > 500
    assert rows.mean() < 120 and columns.mean() < 150


def test_plans_stand_beside_one_another(small, small_room: Scene, tmp_path: Path) -> None:
    plans([small_room, Scene.from_dict(small)], tmp_path / "plans.png", 200)
    image = cv2.imread(str(tmp_path / "plans.png"))
    alone = [top_view(scene, 200).shape[1] for scene in (small_room, Scene.from_dict(small))]
    assert image.shape == (234, sum(alone), 3)
    assert image[205:, :alone[0]].min() < 120, "a caption below"


def test_a_door_is_open_in_the_top_view(small) -> None:
    """The wall at x = 2 m is dark but for its gap, 0.6 to 1.5 m up."""
    image = top_view(Scene.from_dict(small), 260)
    at = image.shape[1] - 6 - round(1.3 * 100)
    assert image[260 - 30 - 20, at].max() < 60 < image[260 - 30 - 105, at].min()
