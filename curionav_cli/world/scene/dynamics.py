"""What changes between episodes: the light and the places of movable things.

Both are pure functions of (the scene's file, seed, episode): no state, so that a resumed run, a second
process and episode 700 asked for first all see the same world.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from curionav_cli.constants import Stream
from curionav_cli.world.scene.scene_format import Light, Move

DARKEST = 0.2
PERIODS = 100_000  # after so many a thing stands at home again and a new stream begins: no episode is far away


class Item(NamedTuple):
    """A movable thing and where its file puts it."""

    name: str
    home: tuple[float, float]


def brightness(light: Light, episode: int, seed: int) -> float:
    """How bright the scene is, 1 = as painted: a slow wave whose phase the seed draws, and noise."""
    if not light.drift and not light.sigma:
        return 1.0
    phase = np.random.default_rng([seed, Stream.light]).uniform(0.0, 2.0 * math.pi)
    wave = 0.5 - 0.5 * math.cos(2.0 * math.pi * episode / light.period + phase)
    noise = np.random.default_rng([seed, Stream.light, episode + 1]).normal(0.0, light.sigma)
    return float(np.clip(1.0 - light.drift * wave + noise, DARKEST, 1.0))


def place(item: Item, move: Move, number: int, episode: int, seed: int) -> tuple[float, float]:
    """Where a thing stands in this episode: at home at first, then wherever each period puts it."""
    places = [item.home, *((x, y) for x, y in move.to)]
    block, periods = divmod(episode // move.every, PERIODS)
    stream = [seed, Stream.moves, number, block] if block else [seed, Stream.moves, number]
    draws = np.random.default_rng(stream).integers(0, len(places) - 1, periods)
    at = 0
    for draw in draws.tolist():
        at = draw + (draw >= at)  # any place but the one it stands in
    return places[at]
