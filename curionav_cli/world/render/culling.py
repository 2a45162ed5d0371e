"""Culling: the boxes that a frame may show, so that a large map costs little more than a small one.

Boxes are listed by the 2 m tile that the camera stands in, out to the corners of its picture at depth
`reach`, and cut down to the wedge that it may see from its square metre; a list is kept for the next frame
there with this heading. Nothing is drawn beyond depth `reach`, which in a scene of more than MANY boxes is
NEAR_REACH: what is farther there is haze. Apart from that, culling never changes an image.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from curionav_cli.geometry import rectangle_distance
from curionav_cli.world.render.box_tables import BoxTables

Tile = tuple[int, int]
Listed = tuple[np.ndarray, np.ndarray]  # boxes, and the ends of the lists among them
TILE = 2.0
SPOT = 1.0
MOST_WEDGES = 4096  # in the cache; 36 for a full turn in one spot
FEW = 96  # below this, trying every box is cheaper than choosing
MANY = 600  # above this, what is deeper than NEAR_REACH is haze
REACH, NEAR_REACH = 60.0, 12.0


class Candidates(NamedTuple):
    """The boxes to try: K for each frame, or the same for all."""

    boxes: np.ndarray  # (B or 1, K) int64: closed ones, FAR_BOX, open ones; filled up with EMPTY
    bounds: np.ndarray  # (2, 2, B or 1, K) float64: low and high, x and y
    walls: int  # the first so many are closed, FAR_BOX the last of them


class Culling:
    """Call with poses (B,) each, for the boxes that each frame should try."""

    def __init__(self, tables: BoxTables, size: tuple[float, float], tangent: float):
        self._tables = tables
        self.reach = NEAR_REACH if tables.boxes > MANY else max(REACH, float(np.hypot(*size)))
        low, high = tables.bounds[:, :, :tables.boxes]  # (2, K) each
        self._middle, self._half = 0.5 * (low + high).T, 0.5 * (high - low).T
        self._tangent = tangent
        self._slant = self.reach * math.hypot(1.0, tangent)  # the depth `reach` at the edge of a picture
        self._tiles: dict[Tile, Listed] = {}
        self._wedges: dict[tuple[Tile, float, float], Candidates] = {}
        self._every = np.arange(tables.boxes)
        self._everything, self._all_listed = self._candidates(self._every), _listed(self._every)

    def __call__(self, x: np.ndarray, y: np.ndarray, cosine: np.ndarray, sine: np.ndarray) -> Candidates:
        if self._tables.boxes <= FEW:
            return self._everything
        poses = zip(x.tolist(), y.tolist(), cosine.tolist(), sine.tolist(), strict=True)
        return _together([self._wedge(*pose) for pose in poses], self._tables)

    def lists(self, x: np.ndarray, y: np.ndarray) -> Listed:
        """The boxes near each place, concatenated, and the ends of the lists; a single list if all share it."""
        if self._tables.boxes <= FEW:
            return self._all_listed
        if len(x) == 1:
            return self._tile(x.item(), y.item())
        lists = [self.near(*place) for place in zip(x.tolist(), y.tolist(), strict=True)]
        return np.concatenate(lists), np.cumsum([len(boxes) for boxes in lists])

    def _candidates(self, boxes: np.ndarray) -> Candidates:
        """The same for one frame: FAR_BOX comes in between the closed boxes and the open ones."""
        shut = int(np.searchsorted(boxes, self._tables.walls))
        boxes = np.insert(boxes, shut, self._tables.boxes)[None]
        return Candidates(boxes, self._tables.bounds.take(boxes, axis=2), shut + 1)

    def _wedge(self, x: float, y: float, cosine: float, sine: float) -> Candidates:
        """The boxes between the left and right edge of the image, for any camera in this spot with this direction."""
        spot = (int(x // SPOT), int(y // SPOT))
        if (spot, cosine, sine) not in self._wedges:
            if len(self._wedges) == MOST_WEDGES:
                self._wedges.clear()
            boxes = self.near(x, y)
            dx, dy = (self._middle.take(boxes, axis=0) - SPOT * (np.array(spot) + 0.5)).T
            wide, deep = (self._half.take(boxes, axis=0) + 0.5 * SPOT).T
            ahead, aside = cosine * dx + sine * dy, sine * dx - cosine * dy
            reach = ahead + abs(cosine) * wide + abs(sine) * deep
            inmost = np.abs(aside) - abs(sine) * wide - abs(cosine) * deep
            visible = boxes[(reach > 0.0) & (inmost < reach * self._tangent)]
            self._wedges[spot, cosine, sine] = self._candidates(visible)
        return self._wedges[spot, cosine, sine]

    def near(self, x: float, y: float) -> np.ndarray:
        """The boxes within reach of the tile around this place, ascending."""
        return self._tile(x, y)[0]

    def _tile(self, x: float, y: float) -> Listed:
        tile = (int(x // TILE), int(y // TILE))
        if tile not in self._tiles:
            low, high = TILE * np.array(tile), TILE * (np.array(tile) + 1)
            across, along = self._middle.T
            away = rectangle_distance(across, along, low, high) - np.hypot(*self._half.T)
            self._tiles[tile] = _listed(np.flatnonzero(away < self._slant))
        return self._tiles[tile]


def _listed(boxes: np.ndarray) -> Listed:
    return boxes, np.array([len(boxes)])


def _together(frames: list[Candidates], tables: BoxTables) -> Candidates:
    """Several frames as one, filled up with EMPTY to the longest list."""
    if len(frames) == 1:
        return frames[0]
    walls = max(frame.walls for frame in frames)
    most = walls + max(frame.boxes.size - frame.walls for frame in frames)
    boxes = np.full((len(frames), most), tables.boxes + 1)
    boxes[:, walls - 1] = tables.boxes
    for row, frame in zip(boxes, frames, strict=True):
        one, at = frame.boxes[0], frame.walls - 1
        row[:at], row[walls:walls + len(one) - at - 1] = one[:at], one[at + 1:]
    return Candidates(boxes, tables.bounds.take(boxes, axis=2), walls)
