"""Which boxes a frame can see at all, so that a big map costs little more than a small one.

Boxes are listed by the 2 m tile the camera stands in, out to the far plane, and cut down to the
camera's wedge. Which boxes are tried never changes a picture, only its cost.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.geometry import rectangle_distance
from curionav_cli.world.surfaces import Surfaces

TILE = 2.0
FEW = 96  # below this, trying every box is cheaper than choosing
MANY = 600  # above this, boxes farther than NEAR_REACH are haze
REACH, NEAR_REACH = 60.0, 12.0


class Culling:
    """Call it with poses: the indices of the boxes to try, (1 or B, K), FAR_BOX last."""

    def __init__(self, surfaces: Surfaces, size: tuple[float, float], tangent: float):
        self._count = surfaces.boxes
        self.reach = NEAR_REACH if self._count > MANY else max(REACH, float(np.hypot(*size)))
        self._all = np.arange(self._count + 1)[None]
        self._low, self._high = surfaces.low[:self._count], surfaces.high[:self._count]
        self._middle, self._half = 0.5 * (self._low + self._high), 0.5 * (self._high - self._low)
        self._tangent = tangent
        self._tiles: dict[tuple[int, int], np.ndarray] = {}

    def __call__(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray) -> np.ndarray:
        if self._count <= FEW:
            return self._all
        lists = [self._wedge(*pose) for pose in zip(x.tolist(), y.tolist(), cosine, sine, strict=True)]
        longest = max(map(len, lists))
        among = np.full((len(lists), longest + 1), self._count + 1)
        among[:, -1] = self._count
        for row, boxes in zip(among, lists, strict=True):
            row[:len(boxes)] = boxes
        return among

    def _wedge(self, x: float, y: float, cosine: float, sine: float) -> np.ndarray:
        """The boxes of this tile that reach into the wedge between the image's left and right edge."""
        boxes = self._near(x, y)
        dx, dy = (self._middle.take(boxes, axis=0) - (x, y)).T
        wide, deep = self._half.take(boxes, axis=0).T
        ahead, aside = cosine * dx + sine * dy, sine * dx - cosine * dy
        reach = ahead + abs(cosine) * wide + abs(sine) * deep
        inmost = np.abs(aside) - abs(sine) * wide - abs(cosine) * deep
        return boxes[(reach > 0.0) & (inmost < reach * self._tangent)]

    def _near(self, x: float, y: float) -> np.ndarray:
        tile = (int(x // TILE), int(y // TILE))
        if tile not in self._tiles:
            low, high = TILE * np.array(tile), TILE * (np.array(tile) + 1)
            across, along = self._middle.T
            away = rectangle_distance(across, along, low, high) - np.hypot(*self._half.T)
            self._tiles[tile] = np.flatnonzero(away < self.reach)
        return self._tiles[tile]
