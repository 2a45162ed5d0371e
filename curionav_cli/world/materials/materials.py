"""Materials by name, `pattern_variant` as in `plaster_sage` or `poster_3`, drawn from the name alone."""

from __future__ import annotations

import zlib

import numpy as np

from curionav_cli.world.materials.furniture_fronts import FITTED
from curionav_cli.world.materials.tiled import COLOURS, SIZE, TILED
from curionav_cli.world.materials.wall_art import ARTWORK

__all__ = ["COLOURS", "PATTERNS", "SIZE", "exists", "picture"]
STRETCHED = {**FITTED, **ARTWORK}
PATTERNS = {**TILED, **STRETCHED}


def picture(name: str) -> np.ndarray:
    """(128, 128, 3) uint8 RGB of a material. Raises KeyError for a pattern that does not exist."""
    pattern, _, variant = name.partition("_")
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    colour = np.array(COLOURS.get(variant, COLOURS[""]), np.float64)
    return np.clip(PATTERNS[pattern](colour, rng), 0, 255).astype(np.uint8)


def exists(name: str) -> bool:
    pattern, _, variant = name.partition("_")
    return pattern in STRETCHED or (pattern in TILED and variant in COLOURS)
