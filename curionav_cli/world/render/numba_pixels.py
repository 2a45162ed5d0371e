"""What the numba engine computes for each pixel: the nearest surface, its texel and its light, and the colour.

`at` is the first of WIDE columns; the places in `work` and `ints` are listed in numba_work.py.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.world.materials.materials import SIZE
from curionav_cli.world.render.numba_work import (
    COLUMNS,
    DEPTH,
    FOOT,
    INTO,
    LIGHT,
    OUT,
    PIXELS,
    RISE,
    ROWS,
    RUN_X,
    RUN_Y,
    SHADE,
    START,
    TEXEL,
    WALL,
    WALL_FOOT,
    WALL_RISE,
    WALL_SHADE,
    WALL_START,
    WIDE,
    compiled,
    either,
    unsigned,
)

LAST, TEXELS = np.int32(SIZE - 1), np.int32(SIZE)
RED_BLUE, GREEN, EIGHT = np.uint32(0xFF00FF), np.uint32(0x00FF00), np.uint32(8)
SIDE, SIXTEEN, ALL, FOURS = (unsigned(count) for count in (COLUMNS, WIDE, PIXELS, PIXELS // 4))
ONE, TWO, THREE, FOUR = (unsigned(number) for number in (1, 2, 3, 4))


@compiled
def draw_planes_and_walls(place, plane, whole, work, ints):
    """Draw floor and ceiling, and the walls before them. plane (R, 5), whole (R, 2): see NumbaEngine."""
    east, north, bright = place
    for r in range(ROWS):
        there, run, rise, first, step = plane[r, 0], plane[r, 1], plane[r, 4], whole[r, 0], whole[r, 1]
        east_of, north_of, glow = east * plane[r, 2], north * plane[r, 2], np.int32(plane[r, 3] * bright)
        row = unsigned(r) * SIDE
        for c in range(SIDE):
            u, v = np.int32(work[RUN_X + c] * run + east_of), np.int32(work[RUN_Y + c] * run + north_of)
            below = np.int32(u * step + v + first)
            texel = np.int32(work[WALL_RISE + c] * rise + work[WALL_FOOT + c]) & LAST
            side, shade, wall = np.int32(ints[WALL_START + c] + texel), ints[WALL_SHADE + c], work[WALL + c]
            shut = wall <= there
            work[DEPTH + row + c] = wall if shut else there
            ints[TEXEL + row + c] = either(shut, side, below)
            ints[LIGHT + row + c] = either(shut, shade, glow)


@compiled
def draw_sides(k, rows, at, near, far, plane, work, ints):
    """Draw the sides of box k where they are nearer than what is drawn."""
    for r in range(rows[0], rows[1]):
        there, gone, rise = near[k, r], far[k, r], plane[r, 4]
        row = unsigned(r) * SIDE + at
        for i in range(SIXTEEN):
            c, p = at + i, row + i
            enter, depth = work[INTO + c], work[DEPTH + p]
            texel = np.int32(ints[START + c] + (np.int32(work[RISE + c] * rise + work[FOOT + c]) & LAST))
            hit = (there <= enter) & (enter < gone) & (enter < depth)
            work[DEPTH + p] = enter if hit else depth
            ints[TEXEL + p] = either(hit, texel, ints[TEXEL + p])
            ints[LIGHT + p] = either(hit, ints[SHADE + c], ints[LIGHT + p])


@compiled
def draw_tops(k, rows, at, near, far, place, address, flats, work, ints):
    """Draw the top or the underside of box k where it is nearer than what is drawn. flats (K, R, 5)."""
    east, north, bright = place
    for r in range(rows[0], rows[1]):
        enter, gone, base, glow = near[k, r], far[k, r], address[k, r], np.int32(flats[k, r, 4] * bright)
        x_scale, x_shift, y_scale, y_shift = flats[k, r, 0], flats[k, r, 1], flats[k, r, 2], flats[k, r, 3]
        row = unsigned(r) * SIDE + at
        for i in range(SIXTEEN):
            c, p = at + i, row + i
            depth = work[DEPTH + p]
            u = np.int32((work[RUN_X + c] * enter + east) * x_scale + x_shift)
            v = np.int32((work[RUN_Y + c] * enter + north) * y_scale + y_shift)
            hit = (enter > work[INTO + c]) & (enter < gone) & (enter < work[OUT + c]) & (enter < depth)
            work[DEPTH + p] = enter if hit else depth
            ints[TEXEL + p] = either(hit, np.int32(base + u * TEXELS + v), ints[TEXEL + p])
            ints[LIGHT + p] = either(hit, glow, ints[LIGHT + p])


@compiled
def store(b, texels, far, work, ints, words, depth):
    """Store frame b: depth (B, R C), at most `far`, and lit colours, four pixels in three words (B, 3 R C / 4)."""
    last = np.int32(len(texels) - 1)
    for p in range(ALL):
        depth[b, p] = min(work[DEPTH + p], far)
    for p in range(ALL):
        ints[TEXEL + p] = min(max(ints[TEXEL + p], np.int32(0)), last)
    for p in range(ALL):
        ints[TEXEL + p] = np.int32(texels[np.uint32(ints[TEXEL + p])])
    for p in range(ALL):
        texel, shade = np.uint32(ints[TEXEL + p]), np.uint32(ints[LIGHT + p])
        red_blue = np.uint32(np.uint32(texel & RED_BLUE) * shade) >> EIGHT
        green = np.uint32(np.uint32(texel & GREEN) * shade) >> EIGHT
        ints[TEXEL + p] = np.int32(np.uint32(red_blue & RED_BLUE) | np.uint32(green & GREEN))
    for four in range(FOURS):
        at, word = TEXEL + FOUR * four, THREE * four
        first, second = np.uint32(ints[at]), np.uint32(ints[at + ONE])
        third, fourth = np.uint32(ints[at + TWO]), np.uint32(ints[at + THREE])
        words[b, word] = first | second << np.uint32(24)
        words[b, word + ONE] = second >> EIGHT | third << np.uint32(16)
        words[b, word + TWO] = third >> np.uint32(16) | fourth << EIGHT
