"""The numba engine: the slab test of numpy_engine.py box by box, in rows of 16 columns. Needs the extra `fast`.

Where numpy tries every box in every column, this projects each box to the columns and rows it can cover. Depths
are computed with the same float32 operations as there, so both engines show the same surfaces but for a
few pixels on edges. numba_columns.py has what belongs to a column, numba_pixels.py what belongs to a pixel.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.world.render.camera import Camera
from curionav_cli.world.render.intersections import Rays
from curionav_cli.world.render.numba_columns import (
    SOON,
    begin_columns,
    cross,
    find_surface,
    keep_nearest,
    range_of_depths,
    span,
)
from curionav_cli.world.render.numba_pixels import draw_planes_and_walls, draw_sides, draw_tops, store
from curionav_cli.world.render.numba_work import COLUMNS, INTS, ROWS, WIDE, WORK, compiled, unsigned


class NumbaEngine:
    """Renders the boxes of one camera with numba."""

    name = "numba"

    def __init__(self, camera: Camera):
        self._camera, tables = camera, camera.tables
        rows = len(camera.slope)
        assert (rows, len(camera.across)) == (ROWS, COLUMNS)
        last, scale = tables.near[-1], tables.x_scale[-rows:]
        flats = (tables.x_scale, tables.x_shift, tables.y_scale, tables.y_shift, tables.light)
        sides = (tables.side_along, tables.side_shift, tables.side_light, tables.side_mip, tables.side_up,
                 tables.side_foot)
        self._tables = (
            np.ascontiguousarray(tables.bounds.transpose(2, 0, 1).reshape(-1, 4)), tables.walls, tables.near,
            tables.far, np.ascontiguousarray(tables.heights.T),
            np.stack([last, last * scale, scale, tables.light[-rows:], camera.slope], axis=1),
            np.stack([tables.address[-rows:], tables.stride[-rows:]], axis=1),
            tables.address.reshape(-1, rows), np.stack([table.reshape(-1, rows) for table in flats], axis=2),
            tables.side_base.reshape(-1, 4), np.stack([table.reshape(-1, 4) for table in sides], axis=1),
            camera.tangent, np.float32(camera.culling.reach), np.float32(camera.far), camera.texels)

    def draw(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray, rays: Rays,
             brightness: np.ndarray, rgb: np.ndarray, depth: np.ndarray) -> None:
        """Render B poses into rgb (B, R, C, 3) uint8 and depth (B, R, C) float32, metres."""
        boxes, ends = self._camera.culling.lists(x, y)
        words = rgb.reshape(len(rgb), -1).view("<u4")
        _frames(x, y, cosine, sine, rays.run, rays.rate, brightness, boxes, ends, *self._tables,
                np.empty(WORK, np.float32), np.empty(INTS, np.int32), words, depth.reshape(len(depth), -1))


@compiled
def _frames(x, y, cosine, sine, run, rate, brightness, boxes, ends, bounds, walls, near, far, heights, plane,
            plane_whole, flat_address, flats, side_base, sides, tangent, reach, most, texels, work, ints, words, depth):
    """The order of NumbaEngine._tables, between what a call brings and where it computes and stores."""
    for b in range(len(x)):
        camera = (x[b], y[b], cosine[b], sine[b], tangent)
        place = (np.float32(x[b]), np.float32(y[b]), np.float32(brightness[b]))
        first, last = ends[b - 1] if b and len(ends) > 1 else 0, ends[b if len(ends) > 1 else 0]
        begin_columns(b, run, rate, reach, side_base[len(bounds) - 3, 0], place[2], work, ints)
        open_ones = _walls(first, last, boxes, walls, bounds, camera, place, side_base, sides, work, ints)
        draw_planes_and_walls(place, plane, plane_whole, work, ints)
        _boxes(open_ones, last, boxes, bounds, camera, place, near, far, heights, plane, flat_address, flats, side_base,
               sides, work, ints)
        store(b, texels, most, work, ints, words, depth)


@compiled
def _corners(bounds, k, camera):
    x, y, _, _, _ = camera
    return bounds[k, 0] - x, bounds[k, 1] - y, bounds[k, 2] - x, bounds[k, 3] - y


@compiled
def _walls(first, last, boxes, walls, bounds, camera, place, side_base, sides, work, ints):
    """Put the closed boxes, which come first, into the columns where they are nearest; where do open ones begin?"""
    for n in range(first, last):
        k = boxes[n]
        if k >= walls:
            return n
        corners = _corners(bounds, k, camera)
        left, right = span(corners, camera)
        for start in range(left // WIDE * WIDE, right, WIDE):
            at = unsigned(start)
            if cross(corners, at, work, ints):
                find_surface(k, place, side_base, sides, at, work, ints)
                keep_nearest(at, work, ints)
    return last


@compiled
def _boxes(first, last, boxes, bounds, camera, place, near, far, heights, plane, flat_address, flats, side_base, sides,
           work, ints):
    """Draw open boxes over what is drawn already, where they are nearer."""
    tangent = camera[4]
    for n in range(first, last):
        k = boxes[n]
        low, high = heights[k, 0], heights[k, 1]
        corners = _corners(bounds, k, camera)
        left, right = span(corners, camera)
        for start in range(left // WIDE * WIDE, right, WIDE):
            at = unsigned(start)
            if cross(corners, at, work, ints):
                find_surface(k, place, side_base, sides, at, work, ints)
                into, out = range_of_depths(at, work)
                into = max(into, SOON)
                rows = _rows(low / (into if low < 0 else out), high / (into if high > 0 else out), tangent)
                draw_sides(k, rows, at, near, far, plane, work, ints)
                if high < 0:
                    rows = _rows(high / into, high / out, tangent)
                    draw_tops(k, rows, at, near, far, place, flat_address, flats, work, ints)
                elif low > 0:
                    rows = _rows(low / out, low / into, tangent)
                    draw_tops(k, rows, at, near, far, place, flat_address, flats, work, ints)


@compiled
def _rows(lowest, highest, tangent):
    """The rows (first, last excluded) with rays of these slopes; a row too many at both ends."""
    top = 0.5 * ROWS * (1.0 - highest / tangent) - 1.5
    bottom = 0.5 * ROWS * (1.0 - lowest / tangent) + 1.5
    return int(min(max(top, 0.0), float(ROWS))), int(min(max(bottom, 0.0), float(ROWS)))
