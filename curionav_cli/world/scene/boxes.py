"""The table of axis-aligned boxes that a scene is made of: walls, furniture, posters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

WEST, EAST, SOUTH, NORTH = range(4)  # the faces -x, +x, -y, +y
FIXED = -1


class Box(NamedTuple):
    """One box, metres; `sides` are the materials of its west, east, south and north face."""

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    sides: tuple[str, str, str, str]
    top: str
    fit: bool = False  # the material is stretched over each face instead of tiled in metres
    item: int = FIXED  # the movable object that it belongs to
    decal: bool = False  # painted on a wall: visible, and no obstacle


@dataclass(frozen=True)
class Boxes:
    """K boxes as columns. low, high (K, 3); sides (K, 4) and top (K,) index `materials`."""

    low: np.ndarray
    high: np.ndarray
    sides: np.ndarray
    top: np.ndarray
    fit: np.ndarray
    item: np.ndarray
    decal: np.ndarray
    materials: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.low)

    @classmethod
    def pack(cls, boxes: list[Box]) -> Boxes:
        """Convert a list of boxes to columns; materials in alphabetical order."""
        materials = tuple(sorted({name for box in boxes for name in (*box.sides, box.top)}))
        number = {name: index for index, name in enumerate(materials)}
        return cls(
            low=np.array([box.low for box in boxes], np.float64).reshape(-1, 3),
            high=np.array([box.high for box in boxes], np.float64).reshape(-1, 3),
            sides=np.array([[number[name] for name in box.sides] for box in boxes], np.int64).reshape(-1, 4),
            top=np.array([number[box.top] for box in boxes], np.int64),
            fit=np.array([box.fit for box in boxes], bool),
            item=np.array([box.item for box in boxes], np.int64),
            decal=np.array([box.decal for box in boxes], bool),
            materials=materials,
        )

    def moved(self, item: int, dx: float, dy: float) -> Boxes:
        """The same boxes with movable object `item` shifted by (dx, dy) metres."""
        shift = np.where(self.item[:, None] == item, np.array([dx, dy, 0.0]), 0.0)
        return replace(self, low=self.low + shift, high=self.high + shift)

    def solid(self, agent_height: float) -> np.ndarray:
        """(K,) bool: the obstacles for a robot of this height, metres."""
        return ~self.decal & (self.low[:, 2] < agent_height)
