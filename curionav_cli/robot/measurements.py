"""What a robot senses. Planner, homing, filter and map know nothing else of the world."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Sensed(NamedTuple):
    """Of one move. wheel: metres by the encoders; gyro: radians, to the left; seconds: how long it took.

    A sensor that gave nothing is nan. time: when the move ended, in seconds on the robot's clock. bump: where the
    bumper is pressed, "left", "centre", "right", or None.
    """

    wheel: float
    gyro: float
    seconds: float
    time: float
    bump: str | None = None


class Shift(NamedTuple):
    """How the robot moved from one scan to the next, by the scans: forward, left (m) and turn (rad), (3,), as seen
    from the first, and covariance (3, 3), large where the scene looks the same all along a direction."""

    motion: np.ndarray
    covariance: np.ndarray


class Scan(NamedTuple):
    """Of a range sensor: bearing (A,) radians from straight ahead, to the left; range (A,) metres from the robot's
    centre, nan for no return. time: when, in seconds on the robot's clock. shift: since the scan before."""

    bearing: np.ndarray
    range: np.ndarray
    time: float
    shift: Shift | None = None
