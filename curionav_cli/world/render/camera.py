"""The camera of a scene: the tables that an engine needs, computed before the first frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curionav_cli.constants import IMAGE_SIDE
from curionav_cli.world.render.box_tables import BoxTables, build_box_tables
from curionav_cli.world.render.culling import Culling
from curionav_cli.world.render.texture_atlas import Atlas
from curionav_cli.world.scene.scene import Scene

FAR = 10.0  # metres; depth is capped here


@dataclass(frozen=True)
class Camera:
    """A level camera. slope (64,) float32: rise of each row's rays per metre of depth; across (64,): to the right."""

    slope: np.ndarray
    across: np.ndarray
    tables: BoxTables
    culling: Culling
    texels: np.ndarray  # uint32, the atlas
    tangent: float  # of half the field of view
    far: float = FAR


def build_camera(scene: Scene, atlas: Atlas) -> Camera:
    """The camera of a scene with its textures."""
    tangent = float(np.tan(np.radians(scene.fov) / 2.0))
    offset = (np.arange(IMAGE_SIDE) + 0.5) / (IMAGE_SIDE / 2) - 1.0
    slope = -tangent * offset
    tables = build_box_tables(scene.boxes, atlas, scene.height, scene.camera, slope, 2.0 * tangent / IMAGE_SIDE)
    return Camera(slope.astype(np.float32), tangent * offset, tables, Culling(tables, scene.size, tangent),
                  atlas.texels, tangent)
