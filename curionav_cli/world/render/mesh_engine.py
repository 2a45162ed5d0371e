"""The engine of scans: a ray for each pixel into a mesh of triangles, by Embree; the camera is that of the boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curionav_cli.constants import IMAGE_SIDE
from curionav_cli.world.render.intersections import Rays
from curionav_cli.world.render.texture_atlas import lit, unpack
from curionav_cli.world.scan.site import ScanView

CHUNK = 8  # frames whose rays are held at once
TILE = 8  # pixels: rays go by squares, which finds them 10 % faster than by rows, as neighbours meet the same triangles
SQUARES = np.arange(IMAGE_SIDE**2).reshape(IMAGE_SIDE // TILE, TILE, -1, TILE).transpose(0, 2, 1, 3).ravel()
ROW, COLUMN = np.divmod(SQUARES, IMAGE_SIDE)
BACK = np.argsort(SQUARES)


@dataclass(frozen=True)
class MeshCamera:
    """A level camera at `height` metres. slope (64,) float32: rise of each row's rays per metre of depth; across
    (64,): to the right; pixel: width of one at depth 1; far: depth is capped here, metres."""

    view: ScanView
    height: float
    slope: np.ndarray
    across: np.ndarray
    pixel: float
    far: float


def build_mesh_camera(view: ScanView, fov: float, height: float, far: float) -> MeshCamera:
    """The camera of a scan. fov: degrees; height: metres above the floor."""
    tangent = float(np.tan(np.radians(fov) / 2.0))
    offset = (np.arange(IMAGE_SIDE) + 0.5) / (IMAGE_SIDE / 2) - 1.0
    return MeshCamera(view, height, (-tangent * offset).astype(np.float32), tangent * offset,
                      2.0 * tangent / IMAGE_SIDE, far)


class MeshEngine:
    """Renders the mesh of one camera."""

    name = "mesh"

    def __init__(self, camera: MeshCamera):
        self._camera = camera

    def draw(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray, rays: Rays,
             brightness: np.ndarray, rgb: np.ndarray, depth: np.ndarray) -> None:
        """Render B poses into rgb (B, R, C, 3) uint8 and depth (B, R, C) float32, metres."""
        for first in range(0, len(x), CHUNK):
            part = slice(first, first + CHUNK)
            pose = np.stack([x[part], y[part]], axis=1).astype(np.float32)
            self._draw(pose, rays.run[part], brightness[part].astype(np.float32), rgb[part], depth[part])

    def _draw(self, pose: np.ndarray, run: np.ndarray, brightness: np.ndarray, rgb: np.ndarray,
              depth: np.ndarray) -> None:
        camera, shape = self._camera, (len(pose), len(SQUARES))
        directions = np.empty((*shape, 3), np.float32)
        directions[..., 0], directions[..., 1] = run[:, 0].take(COLUMN, axis=1), run[:, 1].take(COLUMN, axis=1)
        directions[..., 2] = camera.slope.take(ROW)
        origins = np.empty((*shape, 3), np.float32)
        origins[..., :2], origins[..., 2] = pose[:, None], camera.height
        rays = directions.reshape(-1, 3)
        hits = camera.view.tracer.cast(origins.reshape(-1, 3), rays)
        colour = camera.view.texels.look_up(hits, rays, camera.pixel).reshape(shape)
        far = hits.far.reshape(shape)
        if camera.view.haze or (brightness != 1.0).any():
            light = 256.0 * brightness[:, None] / (np.float32(1.0) + np.float32(camera.view.haze) * far)
            light[hits.face.reshape(shape) < 0] = 256.0
            colour = lit(colour, light.astype(np.uint32))
        unpack(colour.take(BACK, axis=1), rgb)
        np.minimum(far.take(BACK, axis=1).reshape(depth.shape), np.float32(camera.far), out=depth)
