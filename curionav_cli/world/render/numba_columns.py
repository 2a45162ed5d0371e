"""What the numba engine computes for each column: where its ray meets a box, and the texture of the side it meets.

`at` is the first of WIDE columns; the places in `work` and `ints` are listed in numba_work.py. A box that is not met
is met at MISS.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.world.materials.materials import SIZE
from curionav_cli.world.render.box_tables import HAZE
from curionav_cli.world.render.numba_work import (
    AXIS,
    COLUMNS,
    FOOT,
    INTO,
    OUT,
    RATE_X,
    RATE_Y,
    RISE,
    RUN_X,
    RUN_Y,
    SHADE,
    START,
    WALL,
    WALL_FOOT,
    WALL_RISE,
    WALL_SHADE,
    WALL_START,
    WIDE,
    bits,
    compiled,
    either,
    from_bits,
    unsigned,
)
from curionav_cli.world.render.texture_atlas import LEVELS

NEAR = 1e-3  # metres; a box with a corner nearer than this, or behind, may cover every column
SOON = np.float32(1e-6)  # metres; no box is divided by less
MISS = np.float32(np.inf)
HAZE32, ONE, ZERO, FULL = np.float32(HAZE), np.float32(1.0), np.float32(0.0), np.float32(256.0)
LAST, COARSEST, ALL = np.int32(SIZE - 1), np.int32(LEVELS - 1), np.int32(2 * SIZE * SIZE)
NONE, SIXTEEN, EVERY = np.int32(0), unsigned(WIDE), unsigned(COLUMNS)


@compiled
def begin_columns(b, run, rate, reach, haze, bright, work, ints):
    """Note the rays of frame b, and that every column meets the haze at depth `reach`."""
    shade = np.int32(FULL / (HAZE32 * reach + ONE) * bright)
    for c in range(EVERY):
        work[RUN_X + c], work[RUN_Y + c] = run[b, 0, c], run[b, 1, c]
        work[RATE_X + c], work[RATE_Y + c] = rate[b, 0, c], rate[b, 1, c]
        work[WALL + c], work[WALL_RISE + c], work[WALL_FOOT + c] = reach, ZERO, ZERO
        ints[WALL_START + c], ints[WALL_SHADE + c] = haze, shade


@compiled
def span(corners, camera):
    """The columns (first, last excluded) that a ground plan can cover; corners relative to the camera."""
    x0, y0, x1, y1 = corners
    _, _, cosine, sine, tangent = camera
    dx, dy, wide, deep = 0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * (x1 - x0), 0.5 * (y1 - y0)
    most = cosine * dx + sine * dy + abs(cosine) * wide + abs(sine) * deep
    if most <= 0.0 or abs(sine * dx - cosine * dy) - abs(sine) * wide - abs(cosine) * deep >= most * tangent:
        return 0, 0
    nearest, left, right = 1e9, 1e9, -1e9
    for corner in range(4):
        dx, dy = x1 if corner & 1 else x0, y1 if corner & 2 else y0
        ahead, aside = cosine * dx + sine * dy, sine * dx - cosine * dy
        nearest = min(nearest, ahead)
        if ahead > NEAR:
            left, right = min(left, aside / ahead), max(right, aside / ahead)
    if nearest <= NEAR:
        return 0, COLUMNS
    scale, middle = 0.5 * COLUMNS / tangent, 0.5 * COLUMNS - 0.5
    return (int(max(np.floor(left * scale + middle), 0.0)),
            int(min(np.ceil(right * scale + middle), COLUMNS - 1.0)) + 1)


@compiled
def cross(corners, at, work, ints):
    """Note where rays enter and leave a ground plan, and across which axis. Does any meet it before its wall?"""
    met = NONE
    low_x, low_y = np.float32(corners[0]), np.float32(corners[1])
    high_x, high_y = np.float32(corners[2]), np.float32(corners[3])
    for i in range(SIXTEEN):
        c = at + i
        rate_x, rate_y = work[RATE_X + c], work[RATE_Y + c]
        one, other = low_x * rate_x, high_x * rate_x
        into_x, out_x = min(one, other), max(one, other)
        one, other = low_y * rate_y, high_y * rate_y
        into_y, out_y = min(one, other), max(one, other)
        into, out = max(max(into_x, into_y), ZERO), min(out_x, out_y)
        meets = (into < out) & (into <= work[WALL + c])
        work[INTO + c], work[OUT + c] = into if meets else MISS, out if meets else ZERO
        ints[AXIS + c] = np.int32(into_y > into_x)
        met |= np.int32(meets)
    return met != 0


@compiled
def find_surface(k, place, base, side, at, work, ints):
    """Note the texture of the sides of box k that were met. base (K, 4), side (K, 6, 4): see BoxTables."""
    east, north, bright = place
    base_w, base_e, base_s, base_n = base[k, 0], base[k, 1], base[k, 2], base[k, 3]
    along_w, along_e, along_s, along_n = side[k, 0, 0], side[k, 0, 1], side[k, 0, 2], side[k, 0, 3]
    shift_w, shift_e, shift_s, shift_n = side[k, 1, 0], side[k, 1, 1], side[k, 1, 2], side[k, 1, 3]
    light_w, light_e, light_s, light_n = side[k, 2, 0], side[k, 2, 1], side[k, 2, 2], side[k, 2, 3]
    mip_x, mip_y, up, foot = side[k, 3, 0], side[k, 3, 2], side[k, 4, 0], side[k, 5, 0]
    for i in range(SIXTEEN):
        c = at + i
        entry = min(work[INTO + c], work[WALL + c])  # of a miss: anything finite
        run_x, run_y, second = work[RUN_X + c], work[RUN_Y + c], ints[AXIS + c] != 0
        light = (light_s if run_y > ZERO else light_n) if second else (light_w if run_x > ZERO else light_e)
        scale = (along_s if run_y > ZERO else along_n) if second else (along_w if run_x > ZERO else along_e)
        shift = (shift_s if run_y > ZERO else shift_n) if second else (shift_w if run_x > ZERO else shift_e)
        start = (base_s if run_y > ZERO else base_n) if second else (base_w if run_x > ZERO else base_e)
        rate_x, rate_y = work[RATE_X + c], work[RATE_Y + c]
        along_x, along_y = north + run_y * entry, east + run_x * entry
        rate, mip, along = rate_y if second else rate_x, mip_y if second else mip_x, along_y if second else along_x
        wide = bits(entry * entry * abs(rate) * mip)  # its exponent is its logarithm
        level = min(max(((wide >> np.int32(23)) - np.int32(127)) >> np.int32(1), NONE), COARSEST)
        column = (np.int32(along * scale + shift) & LAST) >> level
        ints[START + c] = np.int32(start + (ALL - (ALL >> level)) + column * np.int32(SIZE))
        ints[SHADE + c] = np.int32(light / (HAZE32 * entry + ONE) * bright)
        work[RISE + c], work[FOOT + c] = entry * up, foot


@compiled
def keep_nearest(at, work, ints):
    """Make the box that was met the wall of the columns in which it is nearer than their wall so far."""
    for i in range(SIXTEEN):
        c = at + i
        into, wall = work[INTO + c], work[WALL + c]
        nearer = into < wall
        work[WALL + c] = into if nearer else wall
        work[WALL_RISE + c] = from_bits(either(nearer, bits(work[RISE + c]), bits(work[WALL_RISE + c])))
        work[WALL_FOOT + c] = from_bits(either(nearer, bits(work[FOOT + c]), bits(work[WALL_FOOT + c])))
        ints[WALL_START + c] = either(nearer, ints[START + c], ints[WALL_START + c])
        ints[WALL_SHADE + c] = either(nearer, ints[SHADE + c], ints[WALL_SHADE + c])


@compiled
def range_of_depths(at, work):
    """The least depth at which a ray enters the box, and the greatest at which one leaves it."""
    least, most = bits(MISS), NONE
    for i in range(SIXTEEN):
        least, most = min(least, bits(work[INTO + at + i])), max(most, bits(work[OUT + at + i]))
    return from_bits(least), from_bits(most)
