"""One scene's boxes as its camera sees them: everything that an engine needs, ready before the first frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curionav_cli.world.culling import Culling
from curionav_cli.world.scene import Scene
from curionav_cli.world.surfaces import Surfaces, build_surfaces
from curionav_cli.world.texture import Atlas

SIDE = 64
FAR = 10.0  # metres; depth is capped here


@dataclass(frozen=True)
class View:
    """slope (64,) float32: how far each row's rays rise a metre of depth; across (64,): to the right."""

    slope: np.ndarray
    across: np.ndarray
    surfaces: Surfaces
    culling: Culling
    texels: np.ndarray  # uint32, the atlas
    tangent: float  # of half the field of view
    far: float = FAR


def view(scene: Scene, atlas: Atlas) -> View:
    tangent = float(np.tan(np.radians(scene.fov) / 2.0))
    offset = (np.arange(SIDE) + 0.5) / (SIDE / 2) - 1.0
    slope = -tangent * offset
    surfaces = build_surfaces(scene.boxes, atlas, scene.height, scene.camera, slope, 2.0 * tangent / SIDE)
    return View(slope.astype(np.float32), tangent * offset, surfaces, Culling(surfaces, scene.size, tangent),
                atlas.texels, tangent)
