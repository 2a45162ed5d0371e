"""The numba engine: the slab test of numpy_engine.py as scalar loops, a column at a time. Needs the extra `fast`.

Where numpy tries every box in every column, this projects each box to the columns it can cover. Depths
are computed with the same float32 operations as there, so both engines show the same surfaces but for a
few pixels on edges.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from curionav_cli.world.materials.materials import SIZE
from curionav_cli.world.render.box_tables import HAZE
from curionav_cli.world.render.camera import Camera
from curionav_cli.world.render.intersections import Rays
from curionav_cli.world.render.texture_atlas import LEVEL_OFFSET, LEVELS

MOST = 96  # open boxes in front of one column's wall
NEAR = 1e-3  # metres; a box with a corner nearer than this, or behind, may cover every column
PLANE = np.int32(-1)
RED_BLUE, GREEN, EIGHT = np.uint32(0xFF00FF), np.uint32(0x00FF00), np.uint32(8)
LAST = np.int32(SIZE - 1)
HAZE32, ONE, ZERO = np.float32(HAZE), np.float32(1.0), np.float32(0.0)

compiled = njit(cache=True, nogil=True, error_model="numpy")


class NumbaEngine:
    """Renders the boxes of one camera with numba."""

    name = "numba"

    def __init__(self, camera: Camera):
        self._camera, tables = camera, camera.tables
        rows = len(camera.slope)
        self._bounds = np.ascontiguousarray(tables.bounds.transpose(2, 0, 1).reshape(-1, 4))
        self._heights = (tables.near, tables.far)
        self._flat_address = tables.address.reshape(-1, rows)
        self._flats = tuple(table.reshape(-1, rows) for table in (
            tables.x_scale, tables.x_shift, tables.y_scale, tables.y_shift, tables.light))
        self._plane = (tables.address[-rows:].copy(), tables.stride[-rows:].copy(),
                       tables.x_scale[-rows:].copy(), tables.light[-rows:].copy())
        self._side_base = tables.side_base
        self._sides = np.stack([tables.side_along, tables.side_shift, tables.side_up, tables.side_foot,
                                tables.side_mip, tables.side_light], axis=1)
        self._scale = len(camera.across) / 2 / camera.tangent

    def draw(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray, rays: Rays,
             brightness: np.ndarray, rgb: np.ndarray, depth: np.ndarray) -> None:
        """Render B poses into rgb (B, R, C, 3) uint8 and depth (B, R, C) float32, metres."""
        camera = self._camera
        boxes, ends = camera.culling.lists(x, y)
        words = rgb.reshape(*rgb.shape[:2], -1).view("<u4")  # four pixels are three words
        _frames(x, y, cosine, sine, rays.run, rays.rate, rays.face, brightness, boxes, ends, self._bounds,
                camera.tables.walls, self._heights, self._plane, self._flat_address, self._flats, self._side_base,
                self._sides, camera.slope, self._scale, np.float32(camera.culling.reach), np.float32(camera.far),
                camera.texels, words, depth)


@compiled
def _frames(x, y, cosine, sine, run, rate, face, brightness, boxes, ends, bounds, walls, heights, plane,
            flat_address, flats, side_base, sides, slope, scale, reach, far, texels, words, depth):
    columns, rows = run.shape[2], slope.shape[0]
    count = np.empty(columns, np.int64)
    box, axis = np.empty((columns, MOST), np.int64), np.empty((columns, MOST), np.int64)
    entry, leave = np.empty((columns, MOST), np.float32), np.empty((columns, MOST), np.float32)
    best, seen = np.empty((columns, rows), np.float32), np.empty(rows, np.int32)
    colour = np.empty((columns, rows), np.uint32)
    address, light = np.empty(rows, np.int32), np.empty(rows, np.int32)
    for b in range(len(x)):
        box[:, 0], entry[:, 0], axis[:, 0], count[:] = len(bounds) - 3, reach, 0, 1
        first = ends[b - 1] if b and len(ends) > 1 else 0
        last = ends[b if len(ends) > 1 else 0]
        for k in boxes[first:last]:
            _meet(k, bounds[k], k < walls, x[b], y[b], cosine[b], sine[b], scale, rate[b], count, box, entry,
                  leave, axis)
        east, north, bright = np.float32(x[b]), np.float32(y[b]), np.float32(brightness[b])
        for c in range(columns):
            east_run, north_run = run[b, 0, c], run[b, 1, c]
            _nearest(count[c], box[c], entry[c], leave[c], heights, best[c], seen)
            _planes(east, north, east_run, north_run, heights[0][-1], plane, bright, address, light)
            for n in range(count[c]):
                if entry[c, n] <= entry[c, 0]:
                    k, a = box[c, n], axis[c, n]
                    across = 4 * k + face[b, a, c]
                    along = (north if a == 0 else east) + run[b, 1 - a, c] * entry[c, n]
                    if _side(n, side_base[across], sides[across], entry[c, n], along, rate[b, a, c], bright, slope,
                             seen, address, light):
                        _flat(n, k, east, north, east_run, north_run, best[c], flat_address, flats, bright, seen,
                              address, light)
            _shade(texels, address, light, colour[c])
        _store(colour, best, far, words[b], depth[b])


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
    """What each row of a column sees and how far away: PLANE, or twice a place in its list, plus 1 for a top."""
    near, far = heights
    plane, wall = near[-1], entry[0]
    for r in range(len(best)):
        shut = wall <= plane[r]
        best[r] = wall if shut else plane[r]
        seen[r] = np.int32(0) if shut else PLANE
    for n in range(1, count):
        if entry[n] > wall:
            continue
        enters, leaves, into, out = near[box[n]], far[box[n]], entry[n], leave[n]
        side, top = np.int32(2 * n), np.int32(2 * n + 1)
        for r in range(len(best)):
            enter = max(enters[r], into)
            hit = (enter < min(leaves[r], out)) & (enter < best[r])
            best[r] = enter if hit else best[r]
            seen[r] = (top if enters[r] > into else side) if hit else seen[r]


@compiled
def _planes(east, north, east_run, north_run, near, plane, bright, address, light):
    """Texel and light of floor and ceiling in a column, seen or not."""
    start, stride, scale, shine = plane
    for r in range(len(near)):
        reach = near[r] * scale[r]
        u, v = np.int32(east_run * reach + east * scale[r]), np.int32(north_run * reach + north * scale[r])
        address[r] = np.int32(u * stride[r] + v + start[r])
        light[r] = np.int32(shine[r] * bright)


@compiled
def _side(n, base, side, entry, along, rate, bright, slope, seen, address, light):
    """The same for rows that see the side of the n-th box of the list. Does any see its top or underside?"""
    wide = entry * entry * abs(rate) * side[4]
    level, least = 0, np.float32(4.0)
    while wide >= least and level < LEVELS - 1:
        level, least = level + 1, least * np.float32(4.0)
    column = (int(along * side[0] + side[1]) & (SIZE - 1)) >> level
    start = np.int32(base + LEVEL_OFFSET[level] + column * SIZE)
    shade = np.int32(side[5] / (HAZE32 * entry + ONE) * bright)
    rise, foot, mark, tops = entry * side[2], side[3], np.int32(2 * n), np.int32(0)
    for r in range(len(seen)):
        texel = np.int32(start + (np.int32(rise * slope[r] + foot) & LAST))
        address[r] = texel if seen[r] == mark else address[r]
        light[r] = shade if seen[r] == mark else light[r]
        tops |= np.int32(seen[r] == mark + 1)
    return tops != 0


@compiled
def _flat(n, k, east, north, east_run, north_run, best, flat_address, flats, bright, seen, address, light):
    """The same for rows that see its top or its underside."""
    x_scale, x_shift, y_scale, y_shift, shine = flats
    for r in range(len(seen)):
        if seen[r] == 2 * n + 1:
            u = np.int32((east_run * best[r] + east) * x_scale[k, r] + x_shift[k, r])
            v = np.int32((north_run * best[r] + north) * y_scale[k, r] + y_shift[k, r])
            address[r] = flat_address[k, r] + u * SIZE + v
            light[r] = np.int32(shine[k, r] * bright)


@compiled
def _shade(texels, address, light, colour):
    last = len(texels) - 1
    for r in range(len(address)):
        colour[r] = texels[min(max(address[r], 0), last)]
    for r in range(len(address)):
        texel, shade = colour[r], np.uint32(light[r])
        red_blue = np.uint32(np.uint32(texel & RED_BLUE) * shade) >> EIGHT
        green = np.uint32(np.uint32(texel & GREEN) * shade) >> EIGHT
        colour[r] = np.uint32(red_blue & RED_BLUE) | np.uint32(green & GREEN)


@compiled
def _store(colour, best, far, words, depth):
    """Columns into rows: colour (C, R) packed into words (R, 3 C / 4), best (C, R) capped into depth (R, C)."""
    for r in range(colour.shape[1]):
        for four in range(colour.shape[0] // 4):
            a, b, c, d = colour[4 * four, r], colour[4 * four + 1, r], colour[4 * four + 2, r], colour[4 * four + 3, r]
            words[r, 3 * four] = a | b << np.uint32(24)
            words[r, 3 * four + 1] = b >> EIGHT | c << np.uint32(16)
            words[r, 3 * four + 2] = c >> np.uint32(16) | d << EIGHT
        for column in range(colour.shape[0]):
            depth[r, column] = min(best[column, r], far)
