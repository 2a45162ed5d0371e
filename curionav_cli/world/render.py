"""The camera: 64 x 64 RGB and exact depth of axis-aligned boxes, in numpy, without GL.

Separable slabs. The camera is level, so the ray of column c runs over the floor with forward component
1, and at depth d the ray of row r is at height camera + slope_r d. A box is hit where

    max(tn[box, c], zn[box, r]) < min(tf[box, c], zf[box, r])

with an x-y interval (tn, tf) that depends on the column only and a z interval (zn, zf) on the row only,
known beforehand. Of the boxes nearer than the nearest closed wall of a column, about three, all rows
are evaluated. The index of the winner within its column hides in the low bits of the depth, so that one
integer minimum resolves the picture; its exact depth and texel follow. Nothing is shared between
frames: a frame has the same bytes in a batch of any size.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.world.culling import Culling
from curionav_cli.world.motion import COS, SIN
from curionav_cli.world.scene import Scene
from curionav_cli.world.slabs import RANK, Pairs, find_pairs, nearest, nonzero, wall_texels
from curionav_cli.world.surfaces import build_surfaces
from curionav_cli.world.texture import Atlas, build_atlas

SIDE = 64
FAR = 10.0  # metres; depth is capped here
CHUNK = 16


class Renderer:
    """Draws one scene. Stateless but for its tables: `showing` gives the renderer of a changed scene."""

    def __init__(self, scene: Scene, atlas: Atlas | None = None):
        self.scene = scene
        tangent = np.tan(np.radians(scene.fov) / 2.0)
        offset = (np.arange(SIDE) + 0.5) / (SIDE / 2) - 1.0
        self._across = tangent * offset  # to the right, a metre of depth
        self._pixel = 2.0 * tangent / SIDE
        slope = -tangent * offset
        self._slope = slope.astype(np.float32)
        self._atlas = atlas or build_atlas(scene)
        self._surfaces = build_surfaces(scene.boxes, self._atlas, scene.height, scene.camera, slope,
                                        self._pixel)
        self._culling = Culling(self._surfaces, scene.size, float(tangent))
        plane = self._surfaces.near[-1]
        self._plane = (plane.view(np.uint32) & ~np.uint32(RANK)) | np.uint32(RANK)

    def showing(self, scene: Scene) -> Renderer:
        """The renderer of the same scene in another episode; textures are shared."""
        if scene is self.scene:
            return self
        return Renderer(scene, self._atlas)

    def render(self, x, y, heading) -> tuple[np.ndarray, np.ndarray]:
        """Pictures from poses with integer headings, each scalar or (n,).

        Returns rgb (n, 64, 64, 3) uint8 and depth (n, 64, 64) float32, metres along the optical axis.
        """
        heading = np.atleast_1d(heading)
        return self._all(np.atleast_1d(x), np.atleast_1d(y), COS[heading], SIN[heading])

    def look(self, x, y, yaw) -> tuple[np.ndarray, np.ndarray]:
        """The same for any yaw in radians."""
        yaw = np.atleast_1d(np.asarray(yaw, np.float64))
        return self._all(np.atleast_1d(x), np.atleast_1d(y), np.cos(yaw), np.sin(yaw))

    def _all(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray,
             sine: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        count = len(x)
        rgb = np.empty((count, SIDE, SIDE, 3), np.uint8)
        depth = np.empty((count, SIDE, SIDE), np.float32)
        for first in range(0, count, CHUNK):
            part = slice(first, first + CHUNK)
            self._draw(x[part], y[part], cosine[part], sine[part], rgb[part], depth[part])
        return rgb, depth

    def _draw(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray, rgb: np.ndarray,
              depth: np.ndarray) -> None:
        dx = nonzero(cosine[:, None] + self._across * sine[:, None])  # (B, C) float64
        dy = nonzero(sine[:, None] - self._across * cosine[:, None])
        among = self._culling(x, y, cosine, sine)
        pairs = find_pairs(self._surfaces, among, x, y, dx, dy, self._culling.reach)
        winner = nearest(self._surfaces, pairs, self._plane)
        address, light, metres = self._paint(pairs, winner, x, y, dx, dy)
        texel = self._atlas.texels.take(address, mode="clip")  # beyond the floor: its edge
        red_blue = ((texel & 0xFF00FF) * light >> 8) & 0xFF00FF
        green = ((texel & 0x00FF00) * light >> 8) & 0x00FF00
        shape = (len(x), SIDE, SIDE)
        _unpack((red_blue | green).reshape(shape).transpose(0, 2, 1), rgb)
        np.minimum(metres.reshape(shape).transpose(0, 2, 1), np.float32(FAR), out=depth)

    def _paint(self, pairs: Pairs, winner: np.ndarray, x: np.ndarray, y: np.ndarray, dx: np.ndarray,
               dy: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Texel address, light (0 to 256) and depth of every pixel, flat over (B, C, R)."""
        surfaces = self._surfaces
        cell = (pairs.box * SIDE).take(winner)
        cell += np.arange(SIDE)
        cell, winner = cell.ravel(), winner.ravel()
        entry, level = pairs.entry.take(winner), surfaces.near.ravel().take(cell)
        metres = np.maximum(entry, level)
        foot, up, base, light = wall_texels(surfaces, pairs, self.scene.camera, self._pixel)
        rise = up.take(winner).reshape(-1, SIDE) * self._slope
        address = (rise.ravel() + foot.take(winner)).astype(np.int32) & 127
        address += base.take(winner)
        shade = light.take(winner)
        flat = np.flatnonzero(level > entry)
        column, cell = flat // SIDE, cell.take(flat)
        away = metres.take(flat)
        frame = column // SIDE
        east = dx.astype(np.float32).ravel().take(column) * away + x.astype(np.float32).take(frame)
        north = dy.astype(np.float32).ravel().take(column) * away + y.astype(np.float32).take(frame)
        u = (east * surfaces.x_scale.take(cell) + surfaces.x_shift.take(cell)).astype(np.int32)
        v = (north * surfaces.y_scale.take(cell) + surfaces.y_shift.take(cell)).astype(np.int32)
        address[flat] = surfaces.address.take(cell) + u * surfaces.stride.take(cell) + v
        shade[flat] = surfaces.light.take(cell)
        if self.scene.brightness != 1.0:
            shade *= np.float32(self.scene.brightness)
        return address, shade.astype(np.uint32), metres


def _unpack(packed: np.ndarray, rgb: np.ndarray) -> None:
    """Packed colours (B, 64, 64) uint32 into rgb (B, 64, 64, 3) uint8: four pixels are three words."""
    four = np.ascontiguousarray(packed).reshape(len(packed), SIDE, SIDE // 4, 4)
    words = rgb.reshape(len(packed), SIDE, SIDE * 3).view("<u4").reshape(len(packed), SIDE, SIDE // 4, 3)
    first, second, third, fourth = (four[..., index] for index in range(4))
    words[..., 0] = first | second << 24
    words[..., 1] = second >> 8 | third << 16
    words[..., 2] = third >> 16 | fourth << 8
