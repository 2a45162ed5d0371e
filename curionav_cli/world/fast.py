"""The numba engine: the slabs of paint.py as scalar loops, a column at a time. Needs the extra `fast`.

Where numpy tries every box in every column, this projects each box to the columns it can cover. Depths
are computed with the same float32 operations as there, so both engines see the same surfaces but for the
odd pixel on an edge.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from curionav_cli.world.pattern import SIZE
from curionav_cli.world.slabs import Rays
from curionav_cli.world.surfaces import HAZE
from curionav_cli.world.texture import LEVEL_OFFSET, LEVELS
from curionav_cli.world.view import View

MOST = 96  # open boxes in front of one column's wall
NEAR = 1e-3  # metres; a box with a corner nearer than this, or behind, may cover every column
PLANE = -1
HAZE32, ONE, ZERO = np.float32(HAZE), np.float32(1.0), np.float32(0.0)

compiled = njit(cache=True, nogil=True, error_model="numpy")


class NumbaEngine:
    """Draws the boxes of one view."""

    name = "numba"

    def __init__(self, view: View):
        self._view, surfaces = view, view.surfaces
        flat = (surfaces.address, surfaces.stride, surfaces.x_scale, surfaces.x_shift, surfaces.y_scale,
                surfaces.y_shift, surfaces.light)
        self._bounds = np.ascontiguousarray(surfaces.bounds.transpose(2, 0, 1).reshape(-1, 4))
        self._heights = (surfaces.near, surfaces.far)
        self._level = tuple(table.reshape(surfaces.near.shape) for table in flat)
        self._side_ints = surfaces.side_base.reshape(-1, 4)
        self._sides = np.ascontiguousarray(np.stack([
            table.reshape(-1, 4) for table in (surfaces.side_along, surfaces.side_shift, surfaces.side_up,
                                               surfaces.side_foot, surfaces.side_mip, surfaces.side_light)], axis=2))
        self._scale = len(view.across) / 2 / view.tangent

    def draw(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray, rays: Rays,
             brightness: np.ndarray, rgb: np.ndarray, depth: np.ndarray) -> None:
        """rgb (B, R, C, 3) uint8 and depth (B, R, C) float32 become the pictures of B poses."""
        view = self._view
        boxes, ends = view.culling.lists(x, y)
        _frames(x, y, cosine, sine, rays.run, rays.rate, rays.face, brightness, boxes, ends, self._bounds,
                view.surfaces.walls, self._heights, self._level, self._side_ints, self._sides, view.slope,
                self._scale, np.float32(view.culling.reach), np.float32(view.far), view.texels, rgb, depth)


@compiled
def _frames(x, y, cosine, sine, run, rate, face, brightness, boxes, ends, bounds, walls, heights, level,
            side_base, sides, slope, scale, reach, far, texels, rgb, depth):
    columns, rows = run.shape[2], slope.shape[0]
    count = np.empty(columns, np.int64)
    box = np.empty((columns, MOST), np.int64)
    entry, leave = np.empty((columns, MOST), np.float32), np.empty((columns, MOST), np.float32)
    axis = np.empty((columns, MOST), np.int64)
    best, seen = np.empty(rows, np.float32), np.empty(rows, np.int64)
    for b in range(len(x)):
        box[:, 0], entry[:, 0], axis[:, 0], count[:] = len(bounds) - 3, reach, 0, 1
        first = ends[b - 1] if b and len(ends) > 1 else 0
        last = ends[b if len(ends) > 1 else 0]
        for k in boxes[first:last]:
            _meet(k, bounds[k], k < walls, x[b], y[b], cosine[b], sine[b], scale, rate[b], count, box, entry,
                  leave, axis)
        light = np.float32(brightness[b])
        east, north = np.float32(x[b]), np.float32(y[b])
        for c in range(columns):
            _nearest(count[c], box[c], entry[c], leave[c], heights, best, seen)
            _paint(c, east, north, run[b], rate[b], face[b], light, box[c], entry[c], axis[c], heights[0], level,
                   side_base, sides, slope, texels, best, seen, rgb[b])
            for r in range(rows):
                depth[b, r, c] = min(best[r], far)


@compiled
def _meet(k, bound, closed, x, y, cosine, sine, scale, rate, count, box, entry, leave, axis):
    """Adds a box to the columns whose rays meet it: the nearest closed one in place 0, the open ones after."""
    x0, y0, x1, y1 = bound[0] - x, bound[1] - y, bound[2] - x, bound[3] - y
    first, last = _span(x0, y0, x1, y1, cosine, sine, scale, rate.shape[1])
    low_x, low_y, high_x, high_y = np.float32(x0), np.float32(y0), np.float32(x1), np.float32(y1)
    for c in range(first, last):
        one, other = low_x * rate[0, c], high_x * rate[0, c]
        into_x, out_x = min(one, other), max(one, other)
        one, other = low_y * rate[1, c], high_y * rate[1, c]
        into_y, out_y = min(one, other), max(one, other)
        into, out = max(max(into_x, into_y), ZERO), min(out_x, out_y)
        if into >= out or into > entry[c, 0] or (closed and into == entry[c, 0]):
            continue
        at = 0
        if not closed:
            at = count[c]
            if at == MOST:
                continue
            count[c] += 1
        box[c, at], entry[c, at], leave[c, at], axis[c, at] = k, into, out, into_y > into_x


@compiled
def _span(x0, y0, x1, y1, cosine, sine, scale, columns):
    """The columns (first, last excluded) that a ground plan can cover; places relative to the camera."""
    nearest, farthest, left, right = 1e9, -1e9, 1e9, -1e9
    for corner in range(4):
        dx, dy = x1 if corner & 1 else x0, y1 if corner & 2 else y0
        ahead, aside = cosine * dx + sine * dy, sine * dx - cosine * dy
        nearest, farthest = min(nearest, ahead), max(farthest, ahead)
        if ahead > NEAR:
            left, right = min(left, aside / ahead), max(right, aside / ahead)
    if farthest <= 0.0:
        return 0, 0
    if nearest <= NEAR:
        return 0, columns
    middle = 0.5 * columns - 0.5
    return (int(max(np.floor(left * scale + middle), 0.0)),
            int(min(np.ceil(right * scale + middle), columns - 1.0)) + 1)


@compiled
def _nearest(count, box, entry, leave, heights, best, seen):
    """What each row of a column sees, PLANE or the place of a box in its list, and how far away."""
    near, far = heights
    plane, wall = near[-1], entry[0]
    for r in range(len(best)):
        shut = wall <= plane[r]
        best[r] = wall if shut else plane[r]
        seen[r] = 0 if shut else PLANE
    for n in range(1, count):
        if entry[n] > wall:
            continue
        enters, leaves, into, out = near[box[n]], far[box[n]], entry[n], leave[n]
        for r in range(len(best)):
            enter = max(enters[r], into)
            hit = (enter < min(leaves[r], out)) & (enter < best[r])
            best[r] = enter if hit else best[r]
            seen[r] = n if hit else seen[r]


@compiled
def _paint(c, east, north, run, rate, face, light, box, entry, axis, near, level, side_base, sides, slope,
           texels, best, seen, rgb):
    address, stride, x_scale, x_shift, y_scale, y_shift, shine = level
    last = -2
    base, shade, rise, foot = 0, ZERO, ZERO, ZERO
    for r in range(len(seen)):
        n = seen[r]
        k = len(near) - 1 if n == PLANE else box[n]
        if n == PLANE or near[k, r] > entry[n]:
            u = int((east + run[0, c] * best[r]) * x_scale[k, r] + x_shift[k, r])
            v = int((north + run[1, c] * best[r]) * y_scale[k, r] + y_shift[k, r])
            at = address[k, r] + u * stride[k, r] + v
            bright = int(shine[k, r] * light)
        else:
            if n != last:
                last = n
                a = axis[n]
                base, shade, rise, foot = _side(side_base[k, face[a, c]], sides[k, face[a, c]], entry[n],
                                                (north if a == 0 else east) + run[1 - a, c] * entry[n], rate[a, c])
            at = base + (int(rise * slope[r] + foot) & (SIZE - 1))
            bright = int(shade * light)
        texel = texels[min(at, len(texels) - 1)]
        rgb[r, c, 0] = (texel & 255) * bright >> 8
        rgb[r, c, 1] = (texel >> 8 & 255) * bright >> 8
        rgb[r, c, 2] = (texel >> 16) * bright >> 8


@compiled
def _side(base, side, entry, along, rate):
    """For the side of a box in one column: address of its texel column, light, texel rows a unit of slope, and at 0."""
    wide = entry * entry * abs(rate) * side[4]
    level, least = 0, np.float32(4.0)
    while wide >= least and level < LEVELS - 1:
        level, least = level + 1, least * np.float32(4.0)
    column = (int(along * side[0] + side[1]) & (SIZE - 1)) >> level
    return (base + LEVEL_OFFSET[level] + column * SIZE, side[5] / (ONE + HAZE32 * entry), entry * side[2], side[3])
