"""Our worlds, written as meshes and opened again as scans, are the same to a robot: cells, depth, colours."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from curionav_cli.records import Pose
from curionav_cli.world.render.box_tables import HAZE
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scan.export import export
from curionav_cli.world.scene.map_writer import write_map
from curionav_cli.world.scene.ros_map import OCCUPIED
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

pytest.importorskip("embreex", reason="the extra scan is not installed")
pytest.importorskip("trimesh", reason="the extra scan is not installed")

POSES = 200
COLOUR, TYPICAL = 5.0, 2.0  # mean and median difference of 0 to 255; the boxes halve pictures across only
APART = {"small_room": 0.0}  # share of cells that may differ; the others: half a percent
OFFICE = {
    "name": "office", "size": [6.0, 4.0], "cell": 0.05, "radius": 0.15, "camera": 0.45, "height": 2.6,
    "start": [0.8, 0.8, 0], "walls": [{"line": [3.0, 0.0, 3.0, 4.0], "gaps": [[1.5, 1.0]]}],
    "furniture": [{"kind": "desk", "x": 4.5, "y": 3.4}, {"kind": "chair", "x": 4.5, "y": 2.4, "name": "chair"},
                  {"kind": "lamp", "x": 0.5, "y": 3.5}],
    "moves": [{"item": "chair", "every": 1, "to": [[5.2, 1.0]]}],
}


def worlds(name: str) -> Scene:
    if name == "office":
        return Scene.from_dict(OFFICE, name)
    return Scene.from_dict(*plain(name))


def as_scan(scene: Scene, path: Path) -> Scene:
    """The scene, written and opened again."""
    export(scene, path)
    start = scene.plan.start
    raw, source = plain("scan", mesh=str(path), cell=scene.plan.cell, radius=scene.plan.radius, haze=HAZE,
                        agent_height=scene.agent_height, camera=scene.camera, fov=scene.fov, height=scene.height,
                        start=[start.x, start.y, round(np.degrees(start.yaw))])
    return Scene.from_dict(raw, source)


def on_its_grid(scene: Scene, scan: Scene) -> np.ndarray:
    """The visitable cells of the scene on the grid of the scan."""
    mask = np.zeros_like(scan.plan.visitable)
    row, column = (round(-at / scene.plan.cell) for at in (scan.plan.map_origin.y, scan.plan.map_origin.x))
    rows, columns = scene.plan.visitable.shape
    mask[row:row + rows, column:column + columns] = scene.plan.visitable
    return mask


def compare(scene: Scene, scan: Scene, draw_spots, share: float) -> None:
    cells = on_its_grid(scene, scan)
    assert (cells != scan.plan.visitable).sum() <= share * cells.sum()
    x, y, heading = draw_spots(scene, POSES, 3)
    left, low = scan.plan.map_origin.x, scan.plan.map_origin.y
    image, depth = Renderer(scene).render(x, y, heading, np.ones(POSES))  # a scan keeps the light that it was made in
    seen, far = Renderer(scan).render(x - left, y - low, heading)
    assert (np.abs(depth - far) <= 0.005).mean() >= 0.99
    apart = np.abs(image.astype(int) - seen)
    assert apart.mean() < COLOUR and np.median(apart) <= TYPICAL


@pytest.mark.parametrize("name", [
    "small_room", "office", *(pytest.param(name, marks=pytest.mark.slow) for name in (
        "apartment_0", "apartment_1", "apartment_2", "large_lab"))])
def test_cells_depth_and_colours_come_back(name: str, tmp_path: Path, draw_spots) -> None:
    """As the scene stands in its first episode, with what moves in its place."""
    scene, _ = worlds(name).at(0, 0)
    compare(scene, as_scan(scene, tmp_path / "world.glb"), draw_spots, APART.get(name, 0.005))


def test_what_moves_stands_where_it_stands_in_an_episode(tmp_path: Path, draw_spots) -> None:
    scene = worlds("office")
    now = next(now for episode in range(9) for now, _ in [scene.at(episode, 0)]
               if not np.array_equal(now.boxes.low, scene.boxes.low))
    compare(now, as_scan(now, tmp_path / "later.glb"), draw_spots, 0.005)


@pytest.mark.slow
def test_a_ros_map_comes_back(tmp_path: Path, draw_spots) -> None:
    cells = np.zeros((60, 80), np.int8)
    cells[[0, -1]], cells[:, [0, -1]] = OCCUPIED, OCCUPIED
    for row, column in np.random.default_rng(0).integers(8, 50, (6, 2)):
        cells[row:row + 6, column:column + 4] = OCCUPIED
    write_map(tmp_path / "map.yaml", cells, 0.1, Pose(0.0, 0.0, 0.0))
    scene = Scene.from_dict(*plain("map", map=str(tmp_path / "map.yaml")))
    compare(scene, as_scan(scene, tmp_path / "map.glb"), draw_spots, 0.005)
