"""The camera of a scene: the tables that an engine needs, computed before the first frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curionav_cli.world.render.box_tables import BoxTables, build_box_tables
from curionav_cli.world.render.culling import Culling
from curionav_cli.world.render.optics import offsets
from curionav_cli.world.render.texture_atlas import Atlas
from curionav_cli.world.scene.scene import Scene

FAR = 10.0  # metres; depth is capped here


@dataclass(frozen=True)
class Camera:
    """A level camera of S x S pixels. slope (S,) float32: rise of each row's rays per metre of depth; across (S,): to
    the right."""

    slope: np.ndarray
    across: np.ndarray
    tables: BoxTables
    culling: Culling
    texels: np.ndarray  # uint32, the atlas
    tangent: float  # of half the field of view
    far: float = FAR


def build_camera(scene: Scene, atlas: Atlas, side: int) -> Camera:
    """The camera of a scene with its textures. side: of its images, pixels."""
    tangent, across = offsets(scene.fov, side)
    tables = build_box_tables(scene.boxes, atlas, scene.height, scene.camera, -across, 2.0 * tangent / side)
    return Camera((-across).astype(np.float32), across, tables, Culling(tables, scene.size, tangent), atlas.texels,
                  tangent)
