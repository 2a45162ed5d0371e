"""Maps far larger than what was explored of them, as gmapping and hector write them, and maps that are too large."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from mapmaking import write_map

from curionav_cli.errors import MapError, SceneError
from curionav_cli.world.scene import ros_map
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

SIDE, ROW, COLUMN = 2048, 700, 1300  # of the image, and its first row (from the top) and column of the room


def big(folder: Path, side: int = SIDE, origin: str = "[-51.2, -51.2, 0.0]") -> Path:
    """All unknown but a walled room of 200 x 300 pixels."""
    pixels = np.full((side, side), 205, np.uint8)
    pixels[ROW:ROW + 200, COLUMN:COLUMN + 300] = 0
    pixels[ROW + 1:ROW + 199, COLUMN + 1:COLUMN + 299] = 254
    path = write_map(folder, pixels)
    path.write_text(path.read_text().replace("resolution: 0.1", "resolution: 0.05").replace("[-1.0, 2.0, 0.3]", origin))
    return path


@pytest.mark.parametrize("side", [SIDE, 4000])
def test_a_large_map_is_cropped_to_what_was_explored(tmp_path: Path, side: int) -> None:
    plan = Scene.from_dict(*plain("map", map=str(big(tmp_path, side=side)))).plan
    assert plan.visitable.sum() == 290 * 190 == 55_100
    assert plan.visitable.shape == (200 + 2 * 20, 300 + 2 * 20), "a metre of the unknown around it stays"
    assert plan.map_origin == pytest.approx((-51.2 + (COLUMN - 20) * 0.05, -51.2 + (side - ROW - 200 - 20) * 0.05, 0.0))


def test_a_smaller_map_stays_as_it_is(tmp_path: Path) -> None:
    plan = Scene.from_dict(*plain("map", map=str(big(tmp_path, side=1800)))).plan
    assert plan.visitable.sum() == 55_100 and plan.visitable.shape == (1800, 1800)


def test_the_corner_turns_with_the_map(tmp_path: Path) -> None:
    plan = Scene.from_dict(*plain("map", map=str(big(tmp_path, origin="[1.0, 2.0, 0.5]")))).plan
    x, y = (COLUMN - 20) * 0.05, (SIDE - ROW - 200 - 20) * 0.05
    turned = 1.0 + math.cos(0.5) * x - math.sin(0.5) * y, 2.0 + math.sin(0.5) * x + math.cos(0.5) * y
    assert plan.map_origin == pytest.approx((*turned, 0.5))


def test_what_a_person_places_counts_from_the_image(tmp_path: Path) -> None:
    """The same in a map that is cropped and in one that holds the room alone."""
    left, low = COLUMN * 0.05, (SIDE - ROW - 200) * 0.05

    def scene(path: Path, x: float, y: float) -> Scene:
        return Scene.from_dict(*plain(
            "map", map=str(path), start=[x + 3, y + 3, 90], dock=[x + 2, y + 3, 0], lamps=[[x + 4, y + 4]],
            rooms=[{"rect": [x, y, x + 7.5, y + 10], "wall": "brick", "floor": "parquet"}],
            walls=[{"line": [x + 7.5, y, x + 7.5, y + 9]}], posters=[{"at": [x + 5, y + 0.05], "face": "north"}],
            furniture=[{"kind": "box", "x": x + 5, "y": y + 5, "name": "box"}],
            moves=[{"item": "box", "every": 1, "to": [[x + 6, y + 6]]}]))

    (tmp_path / "alone").mkdir()
    alone = write_map(tmp_path / "alone", np.pad(np.full((198, 298), 254), 1))
    alone.write_text(alone.read_text().replace("resolution: 0.1", "resolution: 0.05"))
    cropped, small = scene(big(tmp_path), left, low), scene(alone, 0.0, 0.0)
    inner = cropped.plan.visitable[20:-20, 20:-20]
    assert np.array_equal(inner, small.plan.visitable) and inner.sum() == cropped.plan.visitable.sum() > 20_000
    for pose, twin in ((cropped.plan.start, small.plan.start), (cropped.dock, small.dock)):
        assert (pose.x - 1.0, pose.y - 1.0, pose.yaw) == pytest.approx(tuple(twin))
    assert np.array(cropped.lamps[-1]) - 1.0 == pytest.approx(np.array(small.lamps[-1]))
    assert np.array(cropped.moves[0].to) - 1.0 == pytest.approx(np.array(small.moves[0].to))
    decal, twin_decal = (one.boxes.low[one.boxes.decal] for one in (cropped, small))
    assert decal[0, :2] - 1.0 == pytest.approx(twin_decal[0, :2])
    said = rf"start \({left + 0.1:g}, {low + 3:g}\) is inside a wall.*spot is \({left + 0.275:g}, "
    with pytest.raises(SceneError, match=said):
        Scene.from_dict(*plain("map", map=str(big(tmp_path)), start=[left + 0.1, low + 3, 0]))
    with pytest.raises(SceneError, match=rf"puts box at \({left + 3:g}, {low + 3:g}\), on the start"):
        Scene.from_dict(*plain("map", map=str(big(tmp_path)), start=[left + 3, low + 3, 0],
                               furniture=[{"kind": "box", "x": left + 5, "y": low + 5, "name": "box"}],
                               moves=[{"item": "box", "every": 1, "to": [[left + 3, low + 3]]}]))


def test_coarser_cells_begin_where_those_of_the_whole_map_do(tmp_path: Path) -> None:
    plan = Scene.from_dict(*plain("map", map=str(big(tmp_path)), cell=0.2)).plan
    offset = (plan.map_origin.x + 51.2) / 0.2, (plan.map_origin.y + 51.2) / 0.2
    assert offset == pytest.approx(np.rint(offset)) and plan.visitable.any()


def test_a_map_that_is_too_large_is_refused_with_a_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit is that of the cropped map, and the cell it names opens it."""
    path = str(big(tmp_path))
    monkeypatch.setattr(ros_map, "MOST_CELLS", 80_000)
    with pytest.raises(MapError, match=r"explored, 17 x 12 m in cells of 0\.05 m, is more than 80000 cells\. "
                                       r"Set env\.cell=0\.1\."):
        Scene.from_dict(*plain("map", map=path))
    assert Scene.from_dict(*plain("map", map=path, cell=0.1)).plan.visitable.sum() > 12_000
    monkeypatch.setattr(ros_map, "MOST_CELLS", 20)
    with pytest.raises(MapError, match=r"is more than 20 cells\. No robot explores so much"):
        Scene.from_dict(*plain("map", map=path))


def test_a_large_map_without_anything_known_has_no_free_cell(tmp_path: Path) -> None:
    path = write_map(tmp_path, np.full((2001, 2001), 205, np.uint8))
    with pytest.raises(MapError, match="the map has no free cell"):
        Scene.from_dict(*plain("map", map=str(path)))


def test_rooms_of_a_map_beyond_the_crop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of more than CELLS every few cells are looked at: the two rooms of a house are still two."""
    from curionav_cli.world.scene import map_furnishing
    free = np.zeros((64, 90), bool)
    free[4:60, 4:42] = free[4:60, 44:86] = free[28:34, 40:46] = True
    fine = map_furnishing.rooms(free, 0.1)
    monkeypatch.setattr(map_furnishing, "CELLS", 3000)
    coarse = map_furnishing.rooms(free, 0.1)
    assert ((coarse >= 0) == free).all() and ((fine >= 0) == free).all()
    for number in (fine, coarse):
        assert number[10, 10] == number[50, 30] != number[50, 80] == number[10, 60]
