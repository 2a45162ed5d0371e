"""What a robot senses. Planner, homing, filter and map know nothing else of the world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Sensed(NamedTuple):
    """Of one move. wheel: metres by the encoders; gyro: radians, to the left; seconds: how long it took.

    A sensor that gave nothing is nan. bump: where the bumper is pressed, "left", "centre", "right", or None.
    """

    wheel: float
    gyro: float
    seconds: float
    bump: str | None = None


class Scan(NamedTuple):
    """Of a range sensor: bearing (A,) radians from straight ahead, to the left; range (A,) metres from the robot's
    centre, nan for no return. time: seconds on the robot's clock."""

    bearing: np.ndarray
    range: np.ndarray
    time: float
