"""Which boxes a frame can see at all, so that a big map costs little more than a small one.

Boxes are listed by the 2 m tile the camera stands in, out to the far plane, and cut down to the
camera's wedge. Which boxes are tried never changes a picture, only its cost.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from curionav_cli.geometry import rectangle_distance
from curionav_cli.world.surfaces import Surfaces

TILE = 2.0
FEW = 96  # below this, trying every box is cheaper than choosing
MANY = 600  # above this, boxes farther than NEAR_REACH are haze
REACH, NEAR_REACH = 60.0, 12.0


class Among(NamedTuple):
    """The boxes to try: K for each frame, or the same for all."""

    boxes: np.ndarray  # (B or 1, K) int64: closed ones, FAR_BOX, open ones; filled up with EMPTY
    bounds: np.ndarray  # (2, 2, B or 1, K) float64: low and high, x and y
    walls: int  # the first so many are closed, FAR_BOX the last of them


class Culling:
    """Call it with poses for the boxes that each frame should try."""

    def __init__(self, surfaces: Surfaces, size: tuple[float, float], tangent: float):
        self._surfaces = surfaces
        self.reach = NEAR_REACH if surfaces.boxes > MANY else max(REACH, float(np.hypot(*size)))
        low, high = surfaces.bounds[:, :, :surfaces.boxes]  # (2, K) each
        self._middle, self._half = 0.5 * (low + high).T, 0.5 * (high - low).T
        self._tangent = tangent
        self._tiles: dict[tuple[int, int], np.ndarray] = {}
        self._every = np.arange(surfaces.boxes)
        self._everything = self._among([self._every])

    def __call__(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray) -> Among:
        if self._surfaces.boxes <= FEW:
            return self._everything
        poses = zip(x.tolist(), y.tolist(), cosine.tolist(), sine.tolist(), strict=True)
        return self._among([self._wedge(*pose) for pose in poses])

    def lists(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The boxes near each place, one after another, and where each list ends; one list where all share it."""
        if self._surfaces.boxes <= FEW:
            return self._every, np.array([len(self._every)])
        lists = [self.near(*place) for place in zip(x.tolist(), y.tolist(), strict=True)]
        return np.concatenate(lists), np.cumsum([len(boxes) for boxes in lists])

    def _among(self, lists: list[np.ndarray]) -> Among:
        count, walls = self._surfaces.boxes, self._surfaces.walls
        split = [int(np.searchsorted(boxes, walls)) for boxes in lists]
        shut = max(split) + 1
        most = shut + max(len(boxes) - at for boxes, at in zip(lists, split, strict=True))
        among = np.full((len(lists), most), count + 1)
        among[:, shut - 1] = count
        for row, boxes, at in zip(among, lists, split, strict=True):
            row[:at], row[shut:shut + len(boxes) - at] = boxes[:at], boxes[at:]
        return Among(among, self._surfaces.bounds.take(among, axis=2), shut)

    def _wedge(self, x: float, y: float, cosine: float, sine: float) -> np.ndarray:
        """The boxes of this tile that reach into the wedge between the image's left and right edge."""
        boxes = self.near(x, y)
        dx, dy = (self._middle.take(boxes, axis=0) - (x, y)).T
        wide, deep = self._half.take(boxes, axis=0).T
        ahead, aside = cosine * dx + sine * dy, sine * dx - cosine * dy
        reach = ahead + abs(cosine) * wide + abs(sine) * deep
        inmost = np.abs(aside) - abs(sine) * wide - abs(cosine) * deep
        return boxes[(reach > 0.0) & (inmost < reach * self._tangent)]

    def near(self, x: float, y: float) -> np.ndarray:
        """The boxes within reach of the tile around this place, ascending."""
        tile = (int(x // TILE), int(y // TILE))
        if tile not in self._tiles:
            low, high = TILE * np.array(tile), TILE * (np.array(tile) + 1)
            across, along = self._middle.T
            away = rectangle_distance(across, along, low, high) - np.hypot(*self._half.T)
            self._tiles[tile] = np.flatnonzero(away < self.reach)
        return self._tiles[tile]
