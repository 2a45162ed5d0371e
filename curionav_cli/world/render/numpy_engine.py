"""The numpy engine: separable slabs, every step over all columns and rows of up to 16 frames at once.

A box is hit where max(tn[box, c], zn[box, r]) < min(tf[box, c], zf[box, r]): an x-y interval (tn, tf) of
the column and a z interval (zn, zf) of the row, which never changes. Boxes behind the nearest closed wall
of a column are dropped, which leaves about two; their rows are evaluated, and one integer minimum over
depth and index resolves the picture. Depth is exact. Nothing is shared between frames: a frame has the
same bytes in a batch of any size.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from curionav_cli.world.materials.materials import SIZE
from curionav_cli.world.render.box_tables import HAZE
from curionav_cli.world.render.camera import Camera
from curionav_cli.world.render.intersections import Pairs, Rays, find_pairs, nearest, unpacked
from curionav_cli.world.render.texture_atlas import LEVEL_OFFSET, LEVELS, lit, unpack

CHUNK = 8
EXPONENT = np.clip(np.arange(256) - 127 >> 1, 0, LEVELS - 1)  # mip level by a float's exponent
OFFSET_OF = LEVEL_OFFSET[EXPONENT].astype(np.int32)
# Marks beside the light of a pixel, and the light itself.
PLANE, TOP, BRIGHT = np.int32(-(1 << 31)), np.int32(1 << 10), np.int32((1 << 10) - 1)


class Texels(NamedTuple):
    """Texture of each surface, by the index of intersections.nearest. Texel: base + row & 127."""

    rise: np.ndarray  # float32: texel rows a unit of slope
    foot: np.ndarray  # float32: texel row at the camera's height
    base: np.ndarray  # int32
    light: np.ndarray  # int32, 256: as painted; PLANE and TOP stand beside it


class NumpyEngine:
    """Renders the boxes of one camera with numpy."""

    name = "numpy"

    def __init__(self, camera: Camera):
        self._camera, tables = camera, camera.tables
        near, rows = tables.near[-1], slice(-len(camera.slope), None)
        self._plane_scale = tables.x_scale[rows]  # of floor and ceiling, a constant of the row
        self._plane_reach = near * self._plane_scale
        self._plane_stride = tables.stride[rows, None]
        self._plane_address = tables.address[rows, None]
        self._plane_light = tables.light[rows]
        self._sides = np.stack([tables.side_along, tables.side_shift, tables.side_mip, tables.side_light,
                                tables.side_up, tables.side_foot], axis=1)
        self._flats = np.stack([tables.near.ravel(), tables.x_scale, tables.x_shift, tables.y_scale,
                                tables.y_shift, tables.light], axis=1)

    def draw(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray, rays: Rays,
             brightness: np.ndarray, rgb: np.ndarray, depth: np.ndarray) -> None:
        """Render B poses into rgb (B, R, C, 3) uint8 and depth (B, R, C) float32, metres."""
        for first in range(0, len(x), CHUNK):
            part = slice(first, first + CHUNK)
            pose = np.array([x[part], y[part]])
            candidates = self._camera.culling(x[part], y[part], cosine[part], sine[part])
            self._draw(pose, candidates, Rays(*(table[part] for table in rays)), brightness[part].astype(np.float32),
                       rgb[part], depth[part])

    def _draw(self, pose: np.ndarray, candidates, rays: Rays, brightness: np.ndarray, rgb: np.ndarray,
              depth: np.ndarray) -> None:
        tables, frames = self._camera.tables, len(rgb)
        pairs = find_pairs(candidates, pose, rays, self._camera.culling.reach)
        place = pose.astype(np.float32)
        best = nearest(tables, pairs, frames)
        seen, metres = unpacked(best.reshape(frames, -1, rgb.shape[1]))  # (B, R, C)
        np.minimum(metres, np.float32(self._camera.far), out=depth)
        texels = self._texels(pairs, rays, place, brightness)
        row = texels.rise.take(seen)
        row *= self._camera.slope[:, None]
        row += texels.foot.take(seen)
        address = row.astype(np.int32)
        address &= SIZE - 1
        address += texels.base.take(seen)
        light = texels.light.take(seen)
        plane = self._plane(rays, place)
        plane &= light >> 31
        address += plane
        self._tops(pairs, rays, place, brightness, seen, address, light)
        light &= BRIGHT
        texel = self._camera.texels.take(address, mode="clip")  # beyond the floor: its edge
        unpack(lit(texel, light.view(np.uint32)), rgb)

    def _texels(self, pairs: Pairs, rays: Rays, place: np.ndarray, brightness: np.ndarray) -> Texels:
        frame, columns = pairs.column // rays.run.shape[2], rays.run.shape[2]
        across = pairs.ray // columns & 1
        other = pairs.ray + columns - 2 * columns * across
        side = pairs.box * 4 + rays.face.take(pairs.ray)
        scale, shift, mip, light, up, foot = self._sides.take(side, axis=0).T
        along = rays.run.take(other) * pairs.entry
        along += place[1 - across, frame]
        along *= scale
        along += shift
        wide = pairs.entry * pairs.entry
        wide *= np.abs(rays.rate.take(pairs.ray))
        wide *= mip
        exponent = wide.view(np.int32) >> 23
        base = ((along.astype(np.int32) & (SIZE - 1)) >> EXPONENT.take(exponent)) * SIZE
        base += OFFSET_OF.take(exponent)
        base += self._camera.tables.side_base.take(side)
        light /= np.float32(HAZE) * pairs.entry + np.float32(1.0)
        light *= brightness.take(frame)
        return self._and_planes(pairs, up * pairs.entry, foot, base, light, brightness)

    def _and_planes(self, pairs: Pairs, rise: np.ndarray, foot: np.ndarray, base: np.ndarray, light: np.ndarray,
                    brightness: np.ndarray) -> Texels:
        """The same with what follows the pairs: tops, painted by _tops, and floor and ceiling."""
        count, tops = len(pairs.box), len(pairs.box) - pairs.walls
        after = count + tops + brightness.size * len(self._plane_light)
        rows, ints = np.zeros((2, after), np.float32), np.zeros((2, after), np.int32)
        rows[0, :count], rows[1, :count], ints[0, :count], ints[1, :count] = rise, foot, base, light
        ints[1, count:count + tops] = TOP
        plane = ints[1, count + tops:]
        np.multiply(brightness[:, None], self._plane_light, out=plane.reshape(len(brightness), -1), casting="unsafe")
        plane |= PLANE
        return Texels(*rows, *ints)

    def _plane(self, rays: Rays, place: np.ndarray) -> np.ndarray:
        """(B, R, C) int32: texel of floor and ceiling under every pixel, whether it is seen or not."""
        run = rays.run[:, :, None] * self._plane_reach[:, None]  # (B, 2, R, C)
        run += (place.T[:, :, None] * self._plane_scale)[..., None]
        texel = run.astype(np.int32)
        address = texel[:, 0] * self._plane_stride
        address += texel[:, 1]
        address += self._plane_address
        return address

    def _tops(self, pairs: Pairs, rays: Rays, place: np.ndarray, brightness: np.ndarray, seen: np.ndarray,
              address: np.ndarray, light: np.ndarray) -> None:
        """Tops and undersides, which are few: address and light of their pixels."""
        tops = len(pairs.box) - pairs.walls
        flat = np.flatnonzero(light == TOP) if tops else ()
        if not len(flat):
            return
        _, rows, columns = seen.shape
        pixel_row, column = flat // columns, flat % columns
        frame = pixel_row // rows
        cell = pairs.box.take(seen.take(flat) - tops) * rows + pixel_row % rows
        away, x_scale, x_shift, y_scale, y_shift, shine = self._flats.take(cell, axis=0).T
        ray = 2 * columns * frame + column
        east = rays.run.take(ray) * away + place[0].take(frame)
        north = rays.run.take(ray + columns) * away + place[1].take(frame)
        u = (east * x_scale + x_shift).astype(np.int32)
        v = (north * y_scale + y_shift).astype(np.int32)
        address.ravel()[flat] = self._camera.tables.address.take(cell) + u * SIZE + v
        light.ravel()[flat] = shine * brightness.take(frame)
