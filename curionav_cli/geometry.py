"""Rectangles in the plane: pure numpy, no state. Metres."""

from __future__ import annotations

import numpy as np


def rectangle_distance(x: np.ndarray, y: np.ndarray, low, high) -> np.ndarray:
    """Distance of points to the closed rectangle low = (x, y) to high = (x, y); 0 inside it."""
    dx = np.maximum(np.maximum(low[0] - x, x - high[0]), 0.0)
    dy = np.maximum(np.maximum(low[1] - y, y - high[1]), 0.0)
    return np.hypot(dx, dy)
