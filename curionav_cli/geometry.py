"""Angles, rectangles and rays in the plane: pure numpy, no state. Metres and radians."""

from __future__ import annotations

import math

import numpy as np


def rectangle_distance(x: np.ndarray | float, y: np.ndarray | float, low, high) -> np.ndarray:
    """Distance of points to the closed rectangle from low = (x, y) to high = (x, y); 0 inside it."""
    dx = np.maximum(np.maximum(low[0] - x, x - high[0]), 0.0)
    dy = np.maximum(np.maximum(low[1] - y, y - high[1]), 0.0)
    return np.hypot(dx, dy)


def wrapped(angle: float) -> float:
    """The same angle in (-pi, pi]."""
    return math.pi - (math.pi - angle) % (2.0 * math.pi)


def ray_ranges(x: float, y: float, cosine: np.ndarray, sine: np.ndarray, low: np.ndarray,
               high: np.ndarray) -> np.ndarray:
    """Ranges (A,) of rays from a point to the nearest of K axis-aligned rectangles; inf for those that hit none.

    cosine, sine (A,): of the rays' directions. low, high (K, 2): corners of the rectangles. All ranges are 0 where
    the point lies inside a rectangle.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        rate_x, rate_y = 1.0 / cosine[:, None], 1.0 / sine[:, None]
        west, east = (low[:, 0] - x) * rate_x, (high[:, 0] - x) * rate_x
        south, north = (low[:, 1] - y) * rate_y, (high[:, 1] - y) * rate_y
    enter = np.fmax(np.fmin(west, east), np.fmin(south, north))
    leave = np.fmin(np.fmax(west, east), np.fmax(south, north))
    enter[(enter > leave) | (leave < 0.0)] = np.inf
    return np.maximum(enter.min(axis=1, initial=np.inf), 0.0)
