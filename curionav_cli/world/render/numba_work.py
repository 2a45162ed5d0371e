"""The memory of the numba engine: `work`, float32, and `ints`, int32, for everything that a frame changes.

numba counts references wherever a function makes an array, even as a slice or a view, or hands on a tuple of them, and
those counts took half of a frame. So no function of the engine does: they take whole arrays and numbers, and places.

LLVM computes eight or sixteen numbers at once only where it can tell that what is written is not what is read next: of
places in one array that are a constant apart, and unsigned, since a signed index might count from the end. Both
sides of a choice are computed, and one is taken by `either`: a branch would keep the numbers apart.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from curionav_cli.constants import IMAGE_SIDE

compiled = njit(cache=True, nogil=True, error_model="numpy")

ROWS = COLUMNS = IMAGE_SIDE
WIDE = 16  # columns that are computed together
PIXELS = ROWS * COLUMNS
unsigned = np.uint64


def _places(after: int, count: int) -> tuple[np.uint64, ...]:
    """`count` places of COLUMNS numbers each."""
    return tuple(unsigned(after + COLUMNS * place) for place in range(count))


# In `work`: the depth of every pixel so far; of every column its ray, where it meets a box, and that side's texture.
DEPTH = unsigned(0)
RUN_X, RUN_Y, RATE_X, RATE_Y, INTO, OUT, RISE, FOOT, WALL, WALL_RISE, WALL_FOOT = _places(PIXELS, 11)
WORK = PIXELS + 11 * COLUMNS
# In `ints`: of every pixel its texel (its colour in the end) and its light, 256: as painted; the rest of a texture.
TEXEL, LIGHT = unsigned(0), unsigned(PIXELS)
AXIS, START, SHADE, WALL_START, WALL_SHADE = _places(2 * PIXELS, 5)
INTS = 2 * PIXELS + 5 * COLUMNS


@compiled
def either(which, one, other):
    """One int32 where which, else the other, without a branch."""
    return np.int32(other ^ np.int32(np.int32(one ^ other) & np.int32(-np.int32(which))))


@compiled
def bits(number):
    """A float32 as the int32 of the same bits; above zero both have the same order."""
    return np.float32(number).view(np.int32)


@compiled
def from_bits(number):
    """The float32 that has these bits."""
    return np.int32(number).view(np.float32)
