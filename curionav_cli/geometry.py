"""Angles and rectangles in the plane: pure numpy, no state. Metres and radians."""

from __future__ import annotations

import numpy as np


def wrap_angle(angle):
    """The same direction in (-pi, pi]."""
    return -((np.pi - np.asarray(angle)) % (2 * np.pi) - np.pi)


def rectangle_distance(x: np.ndarray, y: np.ndarray, low, high) -> np.ndarray:
    """Distance of points to the closed rectangle low = (x, y) to high = (x, y); 0 inside it."""
    dx = np.maximum(np.maximum(low[0] - x, x - high[0]), 0.0)
    dy = np.maximum(np.maximum(low[1] - y, y - high[1]), 0.0)
    return np.hypot(dx, dy)


def overlaps(low: np.ndarray, high: np.ndarray, low2, high2) -> np.ndarray:
    """Which rectangles low, high (n, 2) share area with the rectangle low2 to high2: (n,) bool."""
    return np.all((low < np.asarray(high2)) & (high > np.asarray(low2)), axis=-1)
