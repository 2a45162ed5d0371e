"""What changes between episodes: the light and the places of movable things.

Both are pure functions of (scene file, seed, episode) without state, so that a resumed run, a second process and an
episode that is asked for out of order get the same scene.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from curionav_cli.constants import Stream
from curionav_cli.world.scene.scene_format import Light, Move

DARKEST = 0.2
PERIODS = 100_000  # then an item is at its first place again and a new random stream begins: bounds the cost


class Item(NamedTuple):
    """A movable piece of furniture and its place in the scene file, metres."""

    name: str
    first: tuple[float, float]


def brightness(light: Light, episode: int, seed: int) -> float:
    """The brightness of the scene, 1 = as painted: a slow wave whose phase follows from the seed, plus noise."""
    if not light.drift and not light.sigma:
        return 1.0
    phase = np.random.default_rng([seed, Stream.light]).uniform(0.0, 2.0 * math.pi)
    wave = 0.5 - 0.5 * math.cos(2.0 * math.pi * episode / light.period + phase)
    noise = np.random.default_rng([seed, Stream.light, episode + 1]).normal(0.0, light.sigma)
    return float(np.clip(1.0 - light.drift * wave + noise, DARKEST, 1.0))


def place(item: Item, move: Move, number: int, episode: int, seed: int) -> tuple[float, float]:
    """The place of an item in this episode, metres: its first one, then another in each period. number: of the move."""
    places = [item.first, *((x, y) for x, y in move.to)]
    block, periods = divmod(episode // move.every, PERIODS)
    stream = [seed, Stream.moves, number, block] if block else [seed, Stream.moves, number]
    draws = np.random.default_rng(stream).integers(0, len(places) - 1, periods)
    at = 0
    for draw in draws.tolist():
        at = draw + (draw >= at)  # any place but the present one
    return places[at]
