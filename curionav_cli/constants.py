"""Constants of the whole package: actions and their sizes, options, the image, the streams of random numbers."""

from __future__ import annotations

import math
from enum import Enum, IntEnum

ACTIONS = FORWARD, LEFT, RIGHT = 0, 1, 2
STEP_LENGTH = 0.25  # metres of a forward action
HEADINGS = 36  # in a full turn
TURN_ANGLE = 2.0 * math.pi / HEADINGS  # radians of a left or right action: 10 degrees
IMAGE_SIDE, IMAGE_CHANNELS = 64, 3  # pixels; red, green, blue
IMAGE_SHAPE = IMAGE_SIDE, IMAGE_SIDE, IMAGE_CHANNELS


class Stream(IntEnum):
    """The second number that a generator is seeded by, so that generators of one seed are independent."""

    agent = 1
    predictions = 2
    acting = 3
    probe = 4
    probe_latents = 5
    light = 11
    moves = 12
    robot = 21
    dock = 22
    start = 23


class OptionSet(Enum):
    """The values of agent.options: each action alone, or those of options.py."""

    none = "none"
    seven = "seven"
