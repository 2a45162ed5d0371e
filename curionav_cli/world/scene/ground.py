"""The site of a scene, before inner walls and furniture: floor, outer walls, coverage grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curionav_cli.records import Pose
from curionav_cli.world.scene.boxes import Box
from curionav_cli.world.scene.reachability import TOUCH

ORIGIN = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Rug:
    """A rectangle of the floor in another material."""

    low: tuple[float, float]
    high: tuple[float, float]
    material: str


@dataclass(frozen=True)
class Ground:
    """The floor's material: index (rows, columns) into `materials`, on squares of `cell` metres."""

    index: np.ndarray
    cell: float
    materials: tuple[str, ...]
    rugs: tuple[Rug, ...] = ()


@dataclass(frozen=True)
class Site:
    """A rectangular room or a ROS map, to which the lists of a scene file are added.

    floor (rows, columns) bool: the cells of the building, the only ones that a robot may use.
    origin: of the lower-left corner, in the frame of a ROS map; corner: the same corner in the map's whole image, from
    which start, dock and lists are measured. Of a ROS map also occupancy (rows, columns) int8, and solid (rows,
    columns) bool: the cells that it shows as obstacles. Of a scan also solid, clear (rows, columns) bool: where a
    robot's centre may be, and picture (any, any, 3) uint8: all cells from above, row 0 the lowest.
    """

    size: tuple[float, float]
    cell: float
    boxes: list[Box]
    ground: Ground
    floor: np.ndarray
    lamps: tuple[tuple[float, float], ...] = ()
    origin: Pose = ORIGIN
    corner: tuple[float, float] = (0.0, 0.0)
    occupancy: np.ndarray | None = None
    solid: np.ndarray | None = None
    clear: np.ndarray | None = None
    picture: np.ndarray | None = None


def highest(cells: np.ndarray, resolution: float, shape: tuple[int, int], cell: float) -> np.ndarray:
    """Resample cells (rows, columns) by the highest occupancy in each cell of `cell` metres; keeps thin walls."""
    found = cells
    for axis, (count, most) in enumerate(zip(shape, cells.shape, strict=True)):
        edges = np.arange(count + 1) * (cell / resolution)
        first = np.floor(edges[:-1] + TOUCH).astype(int).clip(0, most - 1)
        last = np.ceil(edges[1:] - TOUCH).astype(int).clip(first + 1, most)
        padded = np.concatenate([found, np.take(found, [-1], axis=axis)], axis=axis)  # reduceat needs last < len
        found = np.maximum.reduceat(padded, np.stack([first, last], 1).ravel(), axis=axis).take(
            np.arange(count) * 2, axis=axis)
    return found.copy()
