"""Hash keys of images: signs of random projections (SimHash, Charikar, 2002), computed in exact whole numbers.

The released C-BET thresholds tanh(A x) + b with a Gaussian A on raw pixels; its tanh is saturated, so that a
digit is the sign of a . x. Here A holds +1 and -1: every partial sum of N numbers of size at most M is a whole
number of size at most N M, and as long as that is below 2^24 a float32 product is exact in whatever order it is
added up. So a key is the same on every machine and for every batch size.

Letters: n images, N actions of an episode, U distinct views.
"""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.agents.distinct import distinct
from curionav_cli.constants import IMAGE_CHANNELS, IMAGE_SHAPE, IMAGE_SIDE

EXACT = 2**24  # whole numbers below are float32 numbers
ROWS = 64  # projected at once
GRIDS = {"raw": IMAGE_SIDE, "grey_16": 16, "grey_8": 8}


class SignKeys:
    """Hashes vectors of whole numbers to keys of `bits` digits, each the sign (-, 0 or +) of one projection."""

    def __init__(self, numbers: int, bits: int, rng: np.random.Generator):
        self.signs = (2 * rng.integers(0, 2, (numbers, bits)) - 1).astype(np.float32)

    def sums(self, vectors: np.ndarray) -> np.ndarray:
        """Project vectors (n, numbers) of whole numbers of any type: (n, bits) float32, exact."""
        parts = [vectors[at:at + ROWS].astype(np.float32) @ self.signs for at in range(0, len(vectors), ROWS)]
        return np.concatenate([np.empty((0, self.signs.shape[1]), np.float32), *parts])

    def __call__(self, vectors: np.ndarray) -> list[bytes]:
        """Return a key for each of the vectors (n, numbers)."""
        sums = self.sums(vectors)
        digits = np.concatenate([np.packbits(sums > 0, axis=1), np.packbits(sums == 0, axis=1)], axis=1)
        return [row.tobytes() for row in digits]


class ImageVector:
    """Turns images into the vectors that are projected: all numbers (raw), or sums of grey over a grid of cells.

    key: raw, grey_16 or grey_8. views: images that are read as one. Raw numbers are 0 to 255, neither scaled nor
    centred, as released. Grey: each cell's sum over its pixels and colours; a state is centred at mid-grey.
    """

    def __init__(self, key: str, views: int):
        self.raw, self.grid = key == "raw", GRIDS[key]
        self.numbers = views * (math.prod(IMAGE_SHAPE) if self.raw else self.grid * self.grid)
        pixels = (IMAGE_SIDE // self.grid) ** 2 * IMAGE_CHANNELS
        self.middle = 0 if self.raw else pixels * 255 // 2
        assert self.numbers * 255 * (1 if self.raw else pixels) < EXACT

    def state(self, images: np.ndarray) -> np.ndarray:
        """Return the vectors (n, numbers) of images (n, views, 64, 64, 3) uint8."""
        return self._read(images) if self.raw else self._read(images) - self.middle

    def change(self, before: np.ndarray, after: np.ndarray, wrapped: bool) -> np.ndarray:
        """Return after - before as vectors (n, numbers), images as in `state`; wrapped: modulo 256, as released."""
        if wrapped:
            return self._read(after - before)
        return self._read(after).astype(np.int32) - self._read(before)

    def _read(self, images: np.ndarray) -> np.ndarray:
        """(n, views, 64, 64, 3) -> (n, numbers)"""
        if self.raw:
            return images.reshape(len(images), -1)
        side = IMAGE_SIDE // self.grid
        cells = images.reshape(-1, self.grid, side, self.grid, side * 3)
        return cells.sum(axis=(2, 4), dtype=np.int32).reshape(len(images), -1)


class StateKeys:
    """Hashes the robot's own images."""

    def __init__(self, key: str, bits: int, rng: np.random.Generator):
        self.vectors = ImageVector(key, 1)
        self.keys = SignKeys(self.vectors.numbers, bits, rng)

    def __call__(self, image: np.ndarray) -> list[bytes]:
        """Return a key for each of the images (n, 64, 64, 3) uint8."""
        first, which = distinct(image)
        keys = self.keys(self.vectors.state(image[first, None]))
        return [keys[number] for number in which.tolist()]


class ChangeKeys:
    """Hashes changes of view. Where nothing changed the key is that of zeros, without a projection."""

    def __init__(self, key: str, bits: int, views: int, wrapped: bool, rng: np.random.Generator):
        self.vectors, self.wrapped = ImageVector(key, views), wrapped
        self.keys = SignKeys(self.vectors.numbers, bits, rng)
        self.nothing = self.keys(np.zeros((1, self.vectors.numbers), np.int8))[0]

    def __call__(self, view: tuple[np.ndarray, np.ndarray], reached: np.ndarray) -> list[bytes]:
        """Return a key for each change from frame n to frame reached[n].

        view: images (U, views, 64, 64, 3), and for each frame (N + 1,) which of them it shows; reached (N,).
        """
        images, which = view
        before, after = which[:len(reached)], which[reached]
        keys = [self.nothing] * len(reached)
        changed = np.flatnonzero(before != after)
        for at in range(0, len(changed), ROWS):
            part = changed[at:at + ROWS]
            change = self.vectors.change(images[before[part]], images[after[part]], self.wrapped)
            for n, key in zip(part.tolist(), self.keys(change), strict=True):
                keys[n] = key
        return keys
