"""What hangs on walls: doors, windows, posters, paintings, mirrors, boards, curtains.

Each is (128, 128, 3), row 0 the lower edge, stretched over its place; the name seeds the picture.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from curionav_cli.world.materials.furniture_fronts import BLACK, BRIGHT, WHITE, Picture, fill, frame, painted, timber
from curionav_cli.world.materials.tiled import COLOURS, SIZE, U, V, noise, plain, shaded

GILT = np.array([176.0, 138.0, 66.0])


def door(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    tone = painted(colour, "brown")
    image = timber(rng, "brown") * (tone / COLOURS["brown"])
    frame(image, 0, SIZE, 0, SIZE, 7, (226, 222, 210))
    for low, high in ((14, 54), (64, 114)):
        for left in (20, 68):
            frame(image, left, left + 40, low, high, 3, 0.62 * tone)
    fill(image, 106, 114, 56, 62, (222, 190, 96))
    return image


def garage(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([206.0, 206.0, 198.0]), 0.02 * noise(rng, 1.0, 12.0), 0.1 * np.sin(V / 2.6))
    image[V[:, 0] % 32 < 2] = (128, 128, 124)
    frame(image, 0, SIZE, 0, SIZE, 5, (96, 98, 100))
    for left in (14, 42, 70, 98):
        fill(image, left, left + 18, 102, 116, (150, 188, 214))
    fill(image, 56, 72, 8, 12, BLACK)
    return image


def window(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    sky = np.stack([150 + 0.55 * V, 190 + 0.4 * V, 226 + 0.2 * V], axis=-1)
    cloud = noise(rng, 7.0, 16.0) + (V - 70) / 40 > 0.9
    sky[cloud] = (246, 248, 250)
    hill = 34 + 9 * np.sin(U / 19.0 + rng.uniform(0, 6)) + 4 * np.sin(U / 7.0) > V
    sky[hill] = (104, 142, 84)
    sky[20 + 5 * np.sin(U / 11.0 + 2) > V] = (78, 116, 68)
    frame(sky, 0, SIZE, 0, SIZE, 8, WHITE)
    fill(sky, 61, 67, 0, SIZE, WHITE)
    sky[70:75] = WHITE
    return sky


def pegboard(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([192.0, 160.0, 112.0]), 0.03 * noise(rng, 3.0))
    image[(V % 8 < 2) & (U % 8 < 2)] = (96, 74, 50)
    for left, low, high, tone in ((14, 30, 104, BRIGHT[0]), (32, 44, 104, BLACK), (56, 60, 108, BRIGHT[1]),
                                  (84, 24, 100, (150, 156, 162)), (104, 50, 104, BRIGHT[2])):
        fill(image, left, left + 6, low, high, (150, 156, 162))
        fill(image, left - 3, left + 9, low, low + (high - low) // 3, tone)
    frame(image, 0, SIZE, 0, SIZE, 4, (120, 90, 58))
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
    frame(image, 0, SIZE, 0, SIZE, 5, BLACK)
    return image


def skyline(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    """A window high above a town."""
    image = np.stack([176 + 0.3 * V, 196 + 0.25 * V, 214 + 0.2 * V], axis=-1).astype(np.float64)
    for tone, most in (((150, 162, 176), 84), ((112, 122, 138), 62), ((82, 88, 100), 40)):
        at = 0
        while at < SIZE:
            wide, tall = int(rng.integers(9, 22)), int(rng.integers(most // 2, most))
            image[:tall, at:at + wide] = tone
            facade = image[:tall - 4, at:at + wide]
            lit = ((V % 8 < 3) & (U % 6 < 3) & (noise(rng, 1.0) > 0.6))[:tall - 4, at:at + wide]
            facade[lit] = (246, 222, 150)
            at += wide
    frame(image, 0, SIZE, 0, SIZE, 5, BLACK)
    for bar in (42, 84):
        fill(image, bar, bar + 3, 0, SIZE, BLACK)
    image[62:65] = BLACK
    return image


def painting(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    """A landscape in a gilt frame: sky, hills, water, trees."""
    dusk = rng.random()
    image = np.stack([150 + 90 * dusk + 0.2 * V, 140 + 0.5 * V, 210 - 110 * dusk + 0.3 * V], axis=-1)
    for number in range(3):
        ridge = 78 - 18 * number + 9 * np.sin(U / rng.uniform(9, 22) + rng.uniform(0, 6))
        image[ridge > V] = np.array([96, 116, 92]) * (1.05 - 0.22 * number) + 30 * rng.uniform(-1, 1, 3)
    water = (rng.uniform(18, 34) > V) & (rng.random() < 0.6)
    image[water] = (96, 130, 152)
    for left in rng.integers(16, 112, 4):
        crown = np.hypot((V - 46) * 0.8, U - left) < rng.uniform(5, 11)
        image[crown] = np.array([60, 92, 52]) * rng.uniform(0.8, 1.5)
        fill(image, left - 1, left + 2, 22, 40, (72, 52, 38))
    image *= (1.0 + 0.05 * noise(rng, 1.0))[..., None]
    frame(image, 0, SIZE, 0, SIZE, 9, GILT)
    frame(image, 9, SIZE - 9, 9, SIZE - 9, 2, 0.5 * GILT)
    return image


def portrait(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array(BRIGHT[rng.integers(8)]) * 0.5, 0.1 * noise(rng, 7.0))
    coat, skin = BRIGHT[rng.integers(8)], np.array([222.0, 178.0, 146.0]) * rng.uniform(0.55, 1.05)
    image[np.hypot((V - 6) * 0.8, U - 64) < 40] = coat
    hair = np.array(BLACK if rng.random() < 0.5 else COLOURS["brown"])
    image[np.hypot((V - 78) * 0.8, U - 64) < 27] = hair
    image[np.hypot((V - 72) * 0.8, U - 64) < 20] = skin
    for left in (55, 70):
        fill(image, left, left + 4, 74, 78, BLACK)
    fill(image, 58, 71, 60, 62, 0.6 * skin)
    frame(image, 0, SIZE, 0, SIZE, 8, np.array(COLOURS["dark"]))
    return image


def mirror(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = shaded(np.array([190.0, 206.0, 212.0]), 0.08 * np.sin((U + V) / 26.0), 0.02 * noise(rng, 9.0))
    frame(image, 0, SIZE, 0, SIZE, 6, painted(colour, "oak"))
    return image


def curtain(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    return shaded(colour, 0.16 * np.sin(U / 3.1 + np.sin(V / 40.0)), 0.03 * noise(rng, 1.0))


def whiteboard(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    image = plain(WHITE)
    for low in range(24, 112, 14):
        fill(image, 12, int(rng.integers(40, 84)), low, low + 3, BRIGHT[rng.integers(4)])
    radius = np.hypot(V - 70, U - 98)
    image[(radius < 18) & (radius > 15)] = BRIGHT[1]
    frame(image, 0, SIZE, 0, SIZE, 4, (150, 154, 158))
    return image


def clock(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    radius, angle = np.hypot(V - 63.5, U - 63.5), np.arctan2(V - 63.5, U - 63.5)
    image = plain(painted(colour, "dark"))
    image[radius < 58] = WHITE
    image[(radius < 54) & (radius > 46) & (np.cos(12 * angle) > 0.8)] = BLACK
    fill(image, 62, 66, 62, 104, BLACK)
    fill(image, 62, 92, 62, 66, BLACK)
    return image


def chart(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    """A map of some world."""
    land = noise(rng, 11.0) + 0.3 * noise(rng, 3.0) > 0.35
    image = np.where(land[..., None], np.array([206.0, 190.0, 130.0]), np.array([140.0, 182.0, 206.0]))
    image[(V % 21 == 0) | (U % 21 == 0)] *= 0.9
    frame(image, 0, SIZE, 0, SIZE, 5, np.array(COLOURS["brown"]))
    return image


def sign(colour: np.ndarray, rng: np.random.Generator) -> Picture:
    """A board with a letter of blocks, as on the wall of a hall: sign_1, sign_2 ... differ."""
    image = plain(0.8 * np.array(BRIGHT[int(rng.integers(8))]))
    half = rng.random((5, 3)) < 0.6
    for row, column in np.argwhere(np.concatenate([half, half[:, 1::-1]], axis=1)):
        fill(image, 24 + 16 * column, 40 + 16 * column, 24 + 16 * row, 40 + 16 * row, WHITE)
    frame(image, 0, SIZE, 0, SIZE, 5, WHITE)
    return image


ARTWORK: dict[str, Callable[[np.ndarray, np.random.Generator], Picture]] = {
    function.__name__: function for function in (
        door, garage, window, skyline, pegboard, poster, painting, portrait, mirror, curtain, whiteboard,
        clock, chart, sign)
}
