"""Pictures of OBJ and glTF on a mesh: which way up they lie, those that are missing, and one of 8192 texels."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from meshmaking import floor_plan_uv, room, write_textured_obj, y_up
from PIL import Image

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.reader import GREY, LARGEST, read_mesh
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

trimesh = pytest.importorskip("trimesh", reason="the extra scan is not installed")
from trimesh.exchange.gltf import export_glb, export_gltf  # noqa: E402

pytest.importorskip("embreex", reason="the extra scan is not installed")

HALL = room(width=10.0, depth=4.0)
RED, BLUE, GREEN = (220, 30, 30), (30, 30, 220), (30, 220, 30)


def from_above(path: Path) -> np.ndarray:
    """Colours of the floor at x 1 m, 2.5 m, 7.5 m and 9 m, y 2.5 m, (4, 3)."""
    plan = Scene.from_dict(*plain("scan", mesh=str(path), cell=0.1)).plan
    pixel = plan.visitable.shape[1] * plan.cell / plan.picture.shape[1]
    row = int((2.5 - plan.map_origin.y) / pixel)
    return plan.picture[row, [int((x - plan.map_origin.x) / pixel) for x in (1.0, 2.5, 7.5, 9.0)]]


def write_gltf(path: Path, side: int) -> Path:
    """A textured GLB, or glTF with its files beside: the picture of write_textured_obj, its upper half green."""
    image = np.empty((side, side, 3), np.uint8)
    image[:side // 2], image[side // 2:, :side // 2], image[side // 2:, side // 2:] = GREEN, RED, BLUE
    places, uv = y_up(HALL).reshape(-1, 3), floor_plan_uv(HALL).reshape(-1, 2)
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(image))
    mesh = trimesh.Trimesh(places, np.arange(len(places)).reshape(-1, 3), process=False,
                           visual=trimesh.visual.TextureVisuals(uv=uv, material=material))
    if path.suffix == ".glb":
        path.write_bytes(export_glb(trimesh.Scene(mesh)))
    else:
        for name, raw in export_gltf(trimesh.Scene(mesh)).items():
            (path if name == "model.gltf" else path.with_name(name)).write_bytes(raw)
    return path


def test_the_picture_of_an_obj_lies_the_right_way(tmp_path: Path) -> None:
    path = write_textured_obj(tmp_path / "hall.obj", HALL)
    assert from_above(path).tolist() == [list(RED)] * 2 + [list(BLUE)] * 2
    (tmp_path / "hall.png").unlink()
    assert (read_mesh(path).colour == 255).all() or (read_mesh(path).colour == GREY).all()  # Kd, or no colour at all
    path.with_suffix(".mtl").write_text("newmtl paint\nmap_Kd ../secret.png\n")
    with pytest.raises(SceneError, match="outside its own folder"):
        read_mesh(path)


@pytest.mark.parametrize(("name", "side"), [
    ("hall.glb", 16), ("hall.gltf", 16), pytest.param("hall.glb", 8192, marks=pytest.mark.slow)])
def test_the_picture_of_gltf_lies_the_right_way(tmp_path: Path, name: str, side: int) -> None:
    """v 0 to 0.4, the hall's depth, is the lower part of the picture, red and blue; green would be upside down."""
    path = write_gltf(tmp_path / name, side)
    assert from_above(path).tolist() == [list(RED)] * 2 + [list(BLUE)] * 2
    assert read_mesh(path).textures[0].shape[0] == min(side, LARGEST)


def test_more_pixels_than_fit_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_textured_obj(tmp_path / "hall.obj", HALL, 32)
    monkeypatch.setattr("curionav_cli.world.scan.picture_limits.MOST_PIXELS", 1000)
    with pytest.raises(SceneError, match="more than 1000 pixels"):
        read_mesh(path)
