"""Tileable surfaces: plaster, brick, planks, cloth. Each is (128, 128, 3), texels of 2 cm, row 0 below."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy import ndimage

SIZE = 128
V, U = np.mgrid[0:SIZE, 0:SIZE]

COLOURS: dict[str, tuple[int, int, int]] = {
    "white": (226, 222, 212), "sand": (214, 190, 150), "sage": (160, 182, 148), "blue": (122, 158, 190),
    "rose": (208, 160, 152), "grey": (168, 170, 172), "ochre": (206, 160, 84), "green": (104, 150, 110),
    "red": (178, 74, 62), "cream": (224, 212, 184), "dark": (96, 66, 46), "oak": (184, 138, 88),
    "pale": (212, 184, 142), "brown": (140, 98, 62), "black": (44, 46, 50), "yellow": (226, 190, 70),
    "purple": (128, 96, 150), "": (180, 176, 168),
}


def noise(rng: np.random.Generator, across: float, along: float = 0.0) -> np.ndarray:
    """(128, 128) tileable noise of unit deviation, smoothed over `across` texels in v, `along` in u."""
    field = ndimage.gaussian_filter(rng.normal(size=(SIZE, SIZE)), (across, along or across), mode="wrap")
    return (field - field.mean()) / field.std()


def plain(colour: np.ndarray) -> np.ndarray:
    return np.broadcast_to(np.asarray(colour, np.float64), (SIZE, SIZE, 3)).copy()


def shaded(colour: np.ndarray, *light: np.ndarray) -> np.ndarray:
    """A colour times one plus the sum of some (128, 128) fields."""
    return colour * (np.ones((SIZE, SIZE)) + sum(light))[..., None]


def plaster(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    wall = shaded(colour, 0.018 * noise(rng, 1.0), 0.03 * noise(rng, 12.0))
    wall[:5] = np.array([238, 236, 230]) * (0.94 + 0.02 * noise(rng, 1.0)[:5, :, None])
    wall[5] *= 0.62
    return wall


def stripe(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    band = (U // 8) % 2 == 0
    wall = plaster(np.array(COLOURS["cream"], np.float64), rng)
    wall[6:][band[6:]] = (0.55 * wall + 0.45 * colour)[6:][band[6:]]
    return wall


def wallpaper(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Rows of small flowers over a skirting board."""
    wall = plaster(colour, rng)
    v, u = V % 16, (U + 8 * (V // 16 % 2)) % 16
    flower = np.hypot(v - 8, u - 8)
    wall[6:][(flower < 4)[6:]] = np.minimum(1.22 * colour, 250)
    wall[6:][(flower < 1.8)[6:]] = 0.62 * colour
    return wall


def wainscot(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Panels of white wood up to 1 m, paint above."""
    wall = plaster(colour, rng)
    low = shaded(np.array(COLOURS["white"], np.float64), 0.015 * noise(rng, 1.0, 9.0))
    groove = (U % 32 < 2) | ((V < 10) & (V > 7)) | ((V > 40) & (V < 43))
    low[groove] *= 0.78
    wall[6:50] = low[6:50]
    wall[47:50] = 0.9 * np.array(COLOURS["white"])
    return wall


def metro(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Glazed tiles up to 2 m, laid like bricks."""
    wall = plaster(np.array(COLOURS["white"], np.float64), rng)
    along = (U + 8 * (V // 8 % 2)) % 16
    glazed = shaded(colour, 0.05 * rng.normal(size=(16, 16))[V // 8, (U + 8 * (V // 8 % 2)) // 16 % 16])
    glazed[(V % 8 == 0) | (along == 0)] = 0.7 * colour
    wall[:104] = glazed[:104]
    return wall


def brick(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Bricks of 24 x 8 texels... stretched to tile: 16 courses, 8 bricks each."""
    course = V // 8
    along = (U + 8 * (course % 2)) % SIZE
    tone = 1.0 + 0.13 * rng.normal(size=(16, 8))[course, along // 16]
    base = np.array([166, 92, 70], np.float64) if colour[0] == COLOURS[""][0] else 0.97 * colour
    wall = base * (tone + 0.05 * noise(rng, 1.0))[..., None]
    wall[(V % 8 == 0) | (along % 16 == 0)] = (176, 168, 156)
    return wall


def panel(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    wall = wood(np.array(COLOURS["pale"], np.float64), rng)
    wall[:, U[0] % 16 == 0] *= 0.6
    return wall


def concrete(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    floor = shaded(np.array([158, 157, 152.0]), 0.03 * noise(rng, 0.8), 0.05 * noise(rng, 9.0))
    floor[(V % 64 == 0) | (U % 64 == 0)] *= 0.78
    return floor


def planks(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    base = colour if colour[0] != COLOURS[""][0] else np.array([178, 132, 86.0])
    row = V // 8
    along = (U + 37 * row) % SIZE
    tone = 0.11 * rng.normal(size=(16, 2))[row, along // 64]
    floor = shaded(base, tone, 0.05 * noise(rng, 0.7, 7.0))
    floor[(V % 8 == 0) | (along % 64 == 0)] *= 0.66
    return floor


def parquet(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    block_v, block_u = V // 16, U // 16
    upright = (block_v + block_u) % 2 == 0
    slat = np.where(upright, (U % 16) // 4, (V % 16) // 4)
    tone = 0.1 * rng.normal(size=(8, 8, 4))[block_v, block_u, slat]
    floor = shaded(np.array([190, 142, 90.0]), tone, 0.03 * noise(rng, 1.0))
    edge = np.where(upright, U % 4 == 0, V % 4 == 0) | (V % 16 == 0) | (U % 16 == 0)
    floor[edge] *= 0.8
    return floor


def tiles(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    tone = 0.035 * rng.normal(size=(8, 8))[V // 16, U // 16]
    checker = np.where((V // 16 + U // 16) % 2 == 0, 0.0, -0.14)
    floor = shaded(colour, tone, checker, 0.015 * noise(rng, 2.0))
    floor[(V % 16 == 0) | (U % 16 == 0)] = 0.62 * colour
    return floor


def carpet(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return shaded(0.8 * colour, 0.09 * noise(rng, 0.6), 0.03 * noise(rng, 6.0))


def rug(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A carpet with borders and a lozenge, for stretching."""
    edge = np.minimum(np.minimum(V, SIZE - 1 - V), np.minimum(U, SIZE - 1 - U))
    cloth = shaded(colour, 0.06 * noise(rng, 0.7))
    cloth[(edge // 4) % 4 == 1] = 0.85 * np.array(COLOURS["cream"])
    lozenge = (np.abs(V - 63.5) + np.abs(U - 63.5)) // 9
    inside = edge > 18
    cloth[inside & (lozenge % 3 == 0)] = 0.9 * np.array(COLOURS["ochre"])
    cloth[inside & (lozenge % 3 == 1)] *= 0.62
    return cloth


def wood(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    grain = 0.07 - 0.045 * (colour.mean() > 200)  # painted white, little of it shows
    return shaded(colour, grain * noise(rng, 1.2, 14.0), 0.4 * grain * noise(rng, 0.7, 3.0))


def fabric(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    weave = 0.05 * ((U // 2 + V // 2) % 2)
    return shaded(colour, weave, 0.05 * noise(rng, 0.8), 0.04 * noise(rng, 14.0))


def metal(colour: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    base = np.array([138, 144, 150.0]) if colour[0] == COLOURS[""][0] else colour
    return shaded(base, 0.04 * noise(rng, 8.0, 0.8), 0.1 * np.sin(V / 9.0))


TILED: dict[str, Callable[[np.ndarray, np.random.Generator], np.ndarray]] = {
    function.__name__: function for function in (
        plaster, stripe, wallpaper, wainscot, metro, brick, panel, concrete, planks, parquet, tiles, carpet,
        rug, wood, fabric, metal)
}
