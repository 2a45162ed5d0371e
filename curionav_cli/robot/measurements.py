"""The measurements of a robot: the only input of planner, navigation, filter and map."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# Bits of the dock's infrared sectors, as a receiver reports them (Kobuki's numbers).
NEAR_LEFT, NEAR_CENTRE, NEAR_RIGHT, FAR_CENTRE, FAR_LEFT, FAR_RIGHT = 1, 2, 4, 8, 16, 32
LEFT, CENTRE, RIGHT, NEAR = NEAR_LEFT | FAR_LEFT, NEAR_CENTRE | FAR_CENTRE, NEAR_RIGHT | FAR_RIGHT, 7

Signals = tuple[int, int, int]  # bits of the right, the centre and the left receiver


class Reading(NamedTuple):
    """Odometry, gyro and bumper over one move. wheel: metres; gyro: radians to the left; seconds: its duration.

    A silent sensor gives nan. time: when the move ended, seconds on the robot's clock. bump: where the bumper is
    pressed, "left", "centre", "right", or None.
    """

    wheel: float
    gyro: float
    seconds: float
    time: float
    bump: str | None = None


class Shift(NamedTuple):
    """The motion from one scan to the next, by scan matching: motion (3,), forward, left (m) and turn (rad) in the
    frame of the first; covariance (3, 3), large along directions in which the scene looks the same."""

    motion: np.ndarray
    covariance: np.ndarray


class Scan(NamedTuple):
    """A scan of a range sensor: bearing (A,) radians to the left of straight ahead; range (A,) metres from the robot's
    centre, nan for no return; time: seconds on the robot's clock; shift: the motion since the previous scan."""

    bearing: np.ndarray
    range: np.ndarray
    time: float
    shift: Shift | None = None
