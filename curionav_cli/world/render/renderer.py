"""The camera: RGB and exact depth, 64 x 64 unless another side is asked for, of axis-aligned boxes, without GL.

The camera is level, so the ray of column c runs over the floor with forward component 1, and at depth d
the ray of row r is at height camera + slope_r d. Two engines draw it, numpy (numpy_engine.py) and numba
(numba_engine.py); they differ in a handful of pixels on edges, so a run keeps to one of them.
"""

from __future__ import annotations

import copy

import numpy as np

from curionav_cli.constants import HEADINGS, IMAGE_SIDE
from curionav_cli.errors import SceneError
from curionav_cli.world.motion import COS, SIN
from curionav_cli.world.render.camera import FAR, Camera, build_camera
from curionav_cli.world.render.intersections import Rays, rays
from curionav_cli.world.render.mesh_engine import MeshCamera, MeshEngine, build_mesh_camera
from curionav_cli.world.render.numpy_engine import NumpyEngine
from curionav_cli.world.render.texture_atlas import Atlas, build_atlas
from curionav_cli.world.scene.scene import Scene

__all__ = ["ENGINES", "FAR", "Renderer"]


def _numba(camera):
    try:
        from curionav_cli.world.render.numba_engine import NumbaEngine
    except ImportError:
        raise SceneError("env.engine=numba needs numba, which is not installed: pip install 'curionav[fast]', "
                         "or env.engine=numpy.") from None
    return NumbaEngine(camera)


ENGINES = {"numpy": NumpyEngine, "numba": _numba}


class Renderer:
    """Renders one scene in images of S x S pixels, S = side. It keeps tables only; `showing` gives the renderer of a
    changed scene."""

    def __init__(self, scene: Scene, engine: str = "numpy", atlas: Atlas | None = None, side: int = IMAGE_SIDE):
        if engine not in ENGINES:
            raise SceneError(f"env.engine must be one of {', '.join(ENGINES)}, not {engine!r}.")
        if scene.view is not None and engine != "numpy":
            raise SceneError(f"env.engine={engine} draws boxes, and a scan is drawn by Embree. Set env.engine=numpy.")
        self.scene = scene
        self.engine, self.side = engine, side
        self._atlas = atlas
        self.camera: Camera | MeshCamera
        if scene.view is not None:
            self.camera = build_mesh_camera(scene.view, scene.fov, scene.camera, FAR, side)
            self._draw = MeshEngine(self.camera).draw
        else:
            self._atlas = atlas or build_atlas(scene)
            self.camera = build_camera(scene, self._atlas, side)
            self._draw = ENGINES[engine](self.camera).draw
        self._headings = rays(COS, SIN, self.camera.across)

    def showing(self, scene: Scene) -> Renderer:
        """The renderer of the same scene in another episode: shares textures, and boxes where none moved."""
        if scene is self.scene:
            return self
        if scene.boxes is not self.scene.boxes:
            return Renderer(scene, self.engine, self._atlas, self.side)
        other = copy.copy(self)
        other.scene = scene
        return other

    def render(self, x, y, heading, brightness=None) -> tuple[np.ndarray, np.ndarray]:
        """Render poses with integer headings, each scalar or (n,); brightness likewise, or that of the scene.

        Returns rgb (n, S, S, 3) uint8 and depth (n, S, S) float32, metres along the optical axis.
        """
        heading = np.atleast_1d(heading)
        chosen = Rays(*(table.take(heading, axis=0) for table in self._headings))
        return self._render(x, y, COS.take(heading), SIN.take(heading), chosen, brightness)

    def look(self, x, y, yaw, brightness=None) -> tuple[np.ndarray, np.ndarray]:
        """Render poses with any yaw, radians; otherwise as `render`."""
        yaw = np.atleast_1d(np.asarray(yaw, np.float64))
        cosine, sine = np.cos(yaw), np.sin(yaw)
        return self._render(x, y, cosine, sine, rays(cosine, sine, self.camera.across), brightness)

    def panorama(self, x, y, heading, views: int = 4, brightness=None) -> tuple[np.ndarray, np.ndarray]:
        """Render `views` directions of each pose, evenly spaced to the left: rgb (n, views, S, S, 3), depth alike.

        Raises ValueError for a number of views that does not divide 36.
        """
        if views < 1 or HEADINGS % views:
            raise ValueError(f"a panorama has 1, 2, 3, 4, 6, 9, 12, 18 or 36 views, not {views}")
        turns = (np.atleast_1d(heading)[:, None] + np.arange(views) * (HEADINGS // views)) % HEADINGS
        x, y = np.repeat(np.atleast_1d(x), views), np.repeat(np.atleast_1d(y), views)
        if brightness is not None:
            brightness = np.repeat(np.atleast_1d(brightness), views)
        rgb, depth = self.render(x, y, turns.ravel(), brightness)
        return rgb.reshape(-1, views, *rgb.shape[1:]), depth.reshape(-1, views, *depth.shape[1:])

    def _render(self, x, y, cosine: np.ndarray, sine: np.ndarray, chosen: Rays,
             brightness) -> tuple[np.ndarray, np.ndarray]:
        x, y = np.array(x, np.float64, ndmin=1), np.array(y, np.float64, ndmin=1)
        rgb = np.empty((len(x), self.side, self.side, 3), np.uint8)
        depth = np.empty((len(x), self.side, self.side), np.float32)
        if brightness is None:
            brightness = np.full(len(x), self.scene.brightness)
        self._draw(x, y, cosine, sine, chosen, brightness, rgb, depth)
        return rgb, depth
