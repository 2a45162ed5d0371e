"""Pictures that are stretched over one face: fronts of furniture. What hangs on walls: wall_art.py.

Each is (128, 128, 3), row 0 the lower edge; `colour` comes from the variant in the name (tiled.py).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from curionav_cli.world.materials.tiled import COLOURS, SIZE, U, V, noise, plain, shaded, wood

Picture = np.ndarray
WHITE, BLACK = np.array([240.0, 238.0, 232.0]), np.array([34.0, 36.0, 40.0])
BRIGHT = [COLOURS[name] for name in ("red", "blue", "yellow", "green", "ochre", "purple", "rose", "sage")]


def fill(image: Picture, left: int, right: int, low: int, high: int, colour) -> None:
    image[low:high, left:right] = colour


def frame(image: Picture, left: int, right: int, low: int, high: int, width: int, colour) -> None:
    for part in ((left, right, low, low + width), (left, right, high - width, high),
                 (left, left + width, low, high), (right - width, right, low, high)):
        fill(image, *part, colour)


def timber(rng: np.random.Generator, name: str = "oak") -> Picture:
    return wood(np.array(COLOURS[name], np.float64), rng)


def painted(colour: np.ndarray, name: str) -> np.ndarray:
    """The colour of a variant, as in doors_sage; without one that of the wood `name`."""
    return np.array(COLOURS[name], np.float64) if tuple(colour) == COLOURS[""] else colour


def books(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = 0.42 * timber(rng)
    for low in range(4, SIZE - 8, 25):
        at = 6
        while at < SIZE - 10:
            wide, tall = int(rng.integers(3, 9)), int(rng.integers(14, 21))
            cover = np.array(BRIGHT[rng.integers(len(BRIGHT))]) * rng.uniform(0.55, 1.0)
            fill(image, at, min(at + wide, SIZE - 6), low, low + tall, cover)
            fill(image, at, at + 1, low, low + tall, 0.5 * cover)
            at += wide + int(rng.random() < 0.12) * 6
        image[low - 4:low] = 0.8 * np.array(COLOURS["oak"])
    frame(image, 0, SIZE, 0, SIZE, 5, 0.85 * np.array(COLOURS["oak"]))
    return image


def goods(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    """Boxes and canisters on steel boards."""
    image = plain(np.array([70.0, 74.0, 80.0]))
    for low in range(6, SIZE - 20, 31):
        at = 5
        while at < SIZE - 16:
            wide, tall = int(rng.integers(10, 24)), int(rng.integers(12, 25))
            tone = np.array([184, 140, 92.0]) if rng.random() < 0.6 else np.array(BRIGHT[rng.integers(8)])
            fill(image, at, min(at + wide, SIZE - 5), low, low + tall, tone * rng.uniform(0.75, 1.05))
            fill(image, at + 2, at + 7, low + tall - 7, low + tall - 3, WHITE)
            at += wide + 2
        image[low - 4:low] = (118, 132, 150)
    frame(image, 0, SIZE, 0, SIZE, 4, (96, 110, 130))
    return image


def doors(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    tone = painted(colour, "pale")
    image = wood(tone, rng)
    for left in (3, 65):
        frame(image, left, left + 60, 6, SIZE - 4, 2, 0.62 * tone)
        frame(image, left + 8, left + 52, 16, SIZE - 14, 2, 0.8 * tone)
    fill(image, 56, 59, 62, 78, BLACK)
    fill(image, 69, 72, 62, 78, BLACK)
    image[:6] = 0.4 * tone
    return image


def drawers(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    tone = painted(colour, "oak")
    image = wood(tone, rng)
    for low in (4, 45, 86):
        frame(image, 3, SIZE - 3, low, low + 39, 2, 0.58 * tone)
        fill(image, 48, 80, low + 22, low + 27, (210, 206, 196))
    return image


def kitchen(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    tone = painted(colour, "white")
    image = shaded(tone, 0.02 * noise(rng, 9.0))
    for left in (0, 43, 86):
        frame(image, left, left + 43, 10, 112, 2, 0.6 * tone)
        fill(image, left + 14, left + 30, 100, 103, BLACK)
    image[116:] = (92, 84, 76)
    image[:9] = (60, 62, 64)
    return image


def fridge(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([214.0, 218.0, 222.0]), 0.02 * noise(rng, 9.0, 1.0))
    image[78:80] = (90, 94, 98)
    fill(image, 10, 15, 40, 74, (110, 114, 118))
    fill(image, 10, 15, 84, 108, (110, 114, 118))
    for at, low in ((50, 90), (70, 104), (92, 94)):
        fill(image, at, at + 12, low, low + 10, BRIGHT[at % 8])
    return image


def stove(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = plain(np.array([196.0, 198.0, 200.0]))
    fill(image, 16, 112, 20, 82, (38, 40, 46))
    fill(image, 26, 102, 32, 70, (92, 62, 40))
    fill(image, 16, 112, 88, 93, BLACK)
    for left in range(18, 108, 18):
        fill(image, left, left + 8, 104, 114, BLACK)
    return image


def screen(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = plain(BLACK)
    glow = np.stack([40 + 0.5 * V, 80 + 0.6 * U, 150 + 0.4 * V], axis=-1)
    image[10:120, 6:122] = glow[10:120, 6:122]
    for row in range(30, 110, 14):
        fill(image, 16, int(rng.integers(40, 110)), row, row + 4, (220, 230, 240))
    return image


def cardboard(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([188.0, 146.0, 98.0]), 0.03 * noise(rng, 1.0, 8.0), 0.04 * noise(rng, 12.0))
    image[58:70] = (206, 186, 140)
    frame(image, 0, SIZE, 0, SIZE, 3, (142, 106, 68))
    fill(image, 16, 44, 20, 44, (238, 236, 228))
    fill(image, 20, 40, 24, 28, BLACK)
    fill(image, 20, 34, 34, 37, BLACK)
    return image


def crate(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = timber(rng, "pale")
    for low in (0, 44, 88):
        image[low + 38:low + 44] = (60, 46, 34)
    fill(image, 4, 14, 0, SIZE, 0.8 * np.array(COLOURS["pale"]))
    fill(image, 114, 124, 0, SIZE, 0.8 * np.array(COLOURS["pale"]))
    return image


def toolbox(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = plain(np.array([190.0, 50.0, 42.0]))
    image[80:86] = (60, 16, 14)
    for left in (24, 92):
        fill(image, left, left + 14, 68, 98, (206, 208, 210))
    frame(image, 0, SIZE, 0, SIZE, 3, (120, 28, 24))
    return image


def tyre(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    radius = np.hypot(V - 63.5, U - 63.5)
    image = plain(np.array([46.0, 47.0, 50.0]))
    image[(U // 5) % 2 == 0] *= 0.75
    image[radius < 58] = (40, 41, 44)
    image[radius < 36] = (150, 154, 158)
    image[(radius < 32) & (np.cos(5 * np.arctan2(V - 63.5, U - 63.5)) < 0)] = (70, 73, 77)
    return image


def leaves(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    return shaded(np.array([70.0, 120.0, 58.0]), 0.3 * noise(rng, 3.0, 3.5), 0.1 * noise(rng, 1.0))


def shade(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    return shaded(np.array([244.0, 222.0, 168.0]), 0.06 * np.cos(U / 4.0), -0.12 * V / SIZE)


def quilt(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    patch = rng.integers(0, 4, (8, 8))[V // 16, U // 16]
    palette = np.array([COLOURS[name] for name in ("blue", "cream", "rose", "sage")], np.float64)
    seam = np.where((V % 16 == 0) | (U % 16 == 0), 0.75, 1.0)
    return palette[patch] * (seam * (1.0 + 0.05 * noise(rng, 1.0)))[..., None]


def linen(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    return shaded(WHITE * 0.97, 0.03 * noise(rng, 5.0))


def terracotta(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    return shaded(np.array([182.0, 104.0, 70.0]), 0.05 * noise(rng, 2.0), -0.15 * (V > 108))


def ceramic(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([236.0, 238.0, 238.0]), 0.01 * noise(rng, 9.0))
    frame(image, 0, SIZE, 0, SIZE, 4, (196, 202, 206))
    return image


def washer(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([232.0, 234.0, 236.0]), 0.01 * noise(rng, 9.0))
    radius = np.hypot(V - 54, U - 64)
    image[radius < 40] = (150, 156, 162)
    image[radius < 32] = np.stack([60 + 0.3 * V, 80 + 0.4 * V, 100 + 0.5 * V], axis=-1)[radius < 32]
    fill(image, 0, SIZE, 104, 106, (150, 154, 158))
    fill(image, 10, 40, 110, 120, (190, 196, 204))
    fill(image, 96, 108, 109, 121, BLACK)
    return image


def piano(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = wood(np.array([58.0, 40.0, 32.0]), rng)
    fill(image, 8, 120, 66, 80, WHITE)
    for left in range(8, 120, 6):
        fill(image, left, left + 1, 66, 80, BLACK)
        fill(image, left + 4, left + 7, 71, 80, BLACK)
    frame(image, 14, 114, 86, 120, 2, (96, 70, 52))
    frame(image, 14, 114, 10, 56, 2, (96, 70, 52))
    return image


def radiator(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(WHITE, 0.12 * np.sin(U / 1.6))
    image[:10] = image[118:] = 0.86 * WHITE
    return image


def aquarium(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = np.stack([30 + 0.3 * V, 90 + 0.6 * V, 130 + 0.7 * V], axis=-1).astype(np.float64)
    image[20 + 5 * np.sin(U / 9.0) > V] = (206, 180, 120)
    for left in (20, 52, 96):
        weed = (np.abs(U - left - 4 * np.sin(V / 7.0)) < 4) & (rng.integers(60, 100) > V)
        image[weed] = (44, 122, 62)
    for _ in range(7):
        v, u = rng.integers(40, 110), rng.integers(16, 112)
        fish = (np.abs(V - v) * 2 + np.abs(U - u)) < 9
        image[fish] = BRIGHT[int(rng.integers(5))] if v % 2 else (240, 130, 40)
    frame(image, 0, SIZE, 0, SIZE, 4, BLACK)
    return image


FITTED: dict[str, Callable[[np.ndarray, np.random.Generator], Picture]] = {
    function.__name__: function for function in (
        books, goods, doors, drawers, kitchen, fridge, stove, screen, cardboard, crate, toolbox, tyre, leaves,
        shade, quilt, linen, terracotta, ceramic, washer, piano, radiator, aquarium)
}
