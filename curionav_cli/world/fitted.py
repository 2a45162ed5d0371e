"""Pictures that are stretched over one face: fronts of furniture, doors, windows, posters.

Each is (128, 128, 3), row 0 the lower edge; `colour` comes from the variant in the name (surface.py).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from curionav_cli.world.surface import COLOURS, SIZE, U, V, noise, plain, shaded, wood

Picture = np.ndarray
WHITE, BLACK = np.array([240.0, 238.0, 232.0]), np.array([34.0, 36.0, 40.0])
BRIGHT = [COLOURS[name] for name in ("red", "blue", "yellow", "green", "ochre", "purple", "rose", "sage")]


def _fill(image: Picture, left: int, right: int, low: int, high: int, colour) -> None:
    image[low:high, left:right] = colour


def _frame(image: Picture, left: int, right: int, low: int, high: int, width: int, colour) -> None:
    for part in ((left, right, low, low + width), (left, right, high - width, high),
                 (left, left + width, low, high), (right - width, right, low, high)):
        _fill(image, *part, colour)


def _oak(rng: np.random.Generator, name: str = "oak") -> Picture:
    return wood(np.array(COLOURS[name], np.float64), rng)


def books(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = 0.42 * _oak(rng)
    for low in range(4, SIZE - 8, 25):
        at = 6
        while at < SIZE - 10:
            wide, tall = int(rng.integers(3, 9)), int(rng.integers(14, 21))
            cover = np.array(BRIGHT[rng.integers(len(BRIGHT))]) * rng.uniform(0.55, 1.0)
            _fill(image, at, min(at + wide, SIZE - 6), low, low + tall, cover)
            _fill(image, at, at + 1, low, low + tall, 0.5 * cover)
            at += wide + int(rng.random() < 0.12) * 6
        image[low - 4:low] = 0.8 * np.array(COLOURS["oak"])
    _frame(image, 0, SIZE, 0, SIZE, 5, 0.85 * np.array(COLOURS["oak"]))
    return image


def goods(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    """Boxes and canisters on steel boards."""
    image = plain(np.array([70.0, 74.0, 80.0]))
    for low in range(6, SIZE - 20, 31):
        at = 5
        while at < SIZE - 16:
            wide, tall = int(rng.integers(10, 24)), int(rng.integers(12, 25))
            tone = np.array([184, 140, 92.0]) if rng.random() < 0.6 else np.array(BRIGHT[rng.integers(8)])
            _fill(image, at, min(at + wide, SIZE - 5), low, low + tall, tone * rng.uniform(0.75, 1.05))
            _fill(image, at + 2, at + 7, low + tall - 7, low + tall - 3, WHITE)
            at += wide + 2
        image[low - 4:low] = (118, 132, 150)
    _frame(image, 0, SIZE, 0, SIZE, 4, (96, 110, 130))
    return image


def doors(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = _oak(rng, "pale")
    for left in (3, 65):
        _frame(image, left, left + 60, 6, SIZE - 4, 2, 0.62 * np.array(COLOURS["pale"]))
        _frame(image, left + 8, left + 52, 16, SIZE - 14, 2, 0.8 * np.array(COLOURS["pale"]))
    _fill(image, 56, 59, 62, 78, BLACK)
    _fill(image, 69, 72, 62, 78, BLACK)
    image[:6] = 0.4 * np.array(COLOURS["pale"])
    return image


def drawers(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = _oak(rng)
    for low in (4, 45, 86):
        _frame(image, 3, SIZE - 3, low, low + 39, 2, 0.58 * np.array(COLOURS["oak"]))
        _fill(image, 48, 80, low + 22, low + 27, (210, 206, 196))
    return image


def kitchen(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = plain(np.array([206.0, 214.0, 210.0]))
    for left in (0, 43, 86):
        _frame(image, left, left + 43, 10, 112, 2, (120, 130, 128))
        _fill(image, left + 14, left + 30, 100, 103, BLACK)
    image[116:] = (92, 84, 76)
    image[:9] = (60, 62, 64)
    return image


def fridge(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([214.0, 218.0, 222.0]), 0.02 * noise(rng, 9.0, 1.0))
    image[78:80] = (90, 94, 98)
    _fill(image, 10, 15, 40, 74, (110, 114, 118))
    _fill(image, 10, 15, 84, 108, (110, 114, 118))
    for at, low in ((50, 90), (70, 104), (92, 94)):
        _fill(image, at, at + 12, low, low + 10, BRIGHT[at % 8])
    return image


def stove(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = plain(np.array([196.0, 198.0, 200.0]))
    _fill(image, 16, 112, 20, 82, (38, 40, 46))
    _fill(image, 26, 102, 32, 70, (92, 62, 40))
    _fill(image, 16, 112, 88, 93, BLACK)
    for left in range(18, 108, 18):
        _fill(image, left, left + 8, 104, 114, BLACK)
    return image


def screen(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = plain(BLACK)
    glow = np.stack([40 + 0.5 * V, 80 + 0.6 * U, 150 + 0.4 * V], axis=-1)
    image[10:120, 6:122] = glow[10:120, 6:122]
    for row in range(30, 110, 14):
        _fill(image, 16, int(rng.integers(40, 110)), row, row + 4, (220, 230, 240))
    return image


def cardboard(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([188.0, 146.0, 98.0]), 0.03 * noise(rng, 1.0, 8.0), 0.04 * noise(rng, 12.0))
    image[58:70] = (206, 186, 140)
    _frame(image, 0, SIZE, 0, SIZE, 3, (142, 106, 68))
    _fill(image, 16, 44, 20, 44, (238, 236, 228))
    _fill(image, 20, 40, 24, 28, BLACK)
    _fill(image, 20, 34, 34, 37, BLACK)
    return image


def crate(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = _oak(rng, "pale")
    for low in (0, 44, 88):
        image[low + 38:low + 44] = (60, 46, 34)
    _fill(image, 4, 14, 0, SIZE, 0.8 * np.array(COLOURS["pale"]))
    _fill(image, 114, 124, 0, SIZE, 0.8 * np.array(COLOURS["pale"]))
    return image


def toolbox(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = plain(np.array([190.0, 50.0, 42.0]))
    image[80:86] = (60, 16, 14)
    for left in (24, 92):
        _fill(image, left, left + 14, 68, 98, (206, 208, 210))
    _frame(image, 0, SIZE, 0, SIZE, 3, (120, 28, 24))
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
    _frame(image, 0, SIZE, 0, SIZE, 4, (196, 202, 206))
    return image


def door(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = _oak(rng, "brown")
    _frame(image, 0, SIZE, 0, SIZE, 7, (226, 222, 210))
    for low, high in ((14, 54), (64, 114)):
        for left in (20, 68):
            _frame(image, left, left + 40, low, high, 3, 0.62 * np.array(COLOURS["brown"]))
    _fill(image, 106, 114, 56, 62, (222, 190, 96))
    return image


def garage(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([206.0, 206.0, 198.0]), 0.02 * noise(rng, 1.0, 12.0), 0.1 * np.sin(V / 2.6))
    image[V[:, 0] % 32 < 2] = (128, 128, 124)
    _frame(image, 0, SIZE, 0, SIZE, 5, (96, 98, 100))
    for left in (14, 42, 70, 98):
        _fill(image, left, left + 18, 102, 116, (150, 188, 214))
    _fill(image, 56, 72, 8, 12, BLACK)
    return image


def window(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    sky = np.stack([150 + 0.55 * V, 190 + 0.4 * V, 226 + 0.2 * V], axis=-1)
    cloud = noise(rng, 7.0, 16.0) + (V - 70) / 40 > 0.9
    sky[cloud] = (246, 248, 250)
    hill = 34 + 9 * np.sin(U / 19.0 + rng.uniform(0, 6)) + 4 * np.sin(U / 7.0) > V
    sky[hill] = (104, 142, 84)
    sky[20 + 5 * np.sin(U / 11.0 + 2) > V] = (78, 116, 68)
    _frame(sky, 0, SIZE, 0, SIZE, 8, WHITE)
    _fill(sky, 61, 67, 0, SIZE, WHITE)
    sky[70:75] = WHITE
    return sky


def pegboard(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([192.0, 160.0, 112.0]), 0.03 * noise(rng, 3.0))
    image[(V % 8 < 2) & (U % 8 < 2)] = (96, 74, 50)
    for left, low, high, tone in ((14, 30, 104, BRIGHT[0]), (32, 44, 104, BLACK), (56, 60, 108, BRIGHT[1]),
                                  (84, 24, 100, (150, 156, 162)), (104, 50, 104, BRIGHT[2])):
        _fill(image, left, left + 6, low, high, (150, 156, 162))
        _fill(image, left - 3, left + 9, low, low + (high - low) // 3, tone)
    _frame(image, 0, SIZE, 0, SIZE, 4, (120, 90, 58))
    return image


def poster(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    """One of many: a seeded composition of sun, hills, stripes or blocks in a dark frame."""
    palette = np.array(BRIGHT, np.float64)[rng.permutation(len(BRIGHT))]
    image = plain(palette[0] * 0.5 + WHITE * 0.5)
    kind = int(rng.integers(4))
    if kind == 0:
        for number in range(4):
            ridge = 92 - 24 * number + 8 * np.sin(U / rng.uniform(9, 20) + rng.uniform(0, 6))
            image[ridge > V] = palette[1 + number]
    elif kind == 1:
        image = palette[((U + V) // 16) % 5 + 1]
    elif kind == 2:
        image = palette[rng.integers(1, 7, (6, 6))[V * 6 // SIZE, U * 6 // SIZE]]
    else:
        for number in range(5):
            image[np.hypot(V - 64, U - 64) < 60 - 12 * number] = palette[number % 6 + 1]
    sun_v, sun_u = rng.uniform(70, 105), rng.uniform(25, 100)
    image[np.hypot(V - sun_v, U - sun_u) < 13] = palette[7]
    _frame(image, 0, SIZE, 0, SIZE, 5, BLACK)
    return image


FITTED: dict[str, Callable[[np.ndarray, np.random.Generator], Picture]] = {
    function.__name__: function for function in (
        books, goods, doors, drawers, kitchen, fridge, stove, screen, cardboard, crate, toolbox, tyre, leaves,
        shade, quilt, linen, terracotta, ceramic, door, garage, window, pegboard, poster)
}
