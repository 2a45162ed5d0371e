"""What a scene starts from before its furniture: the floor, the outer walls, the coverage grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curionav_cli.records import Pose
from curionav_cli.world.boxes import Box

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
    """Four walls and a floor, or a ROS map: what the lists of a scene file are added to.

    floor (rows, columns) bool: the cells of the building, the only ones that a robot may use.
    origin: of the lower-left corner, in the frame of a ROS map; corner: the same corner in the map's whole image, from
    which start, dock and lists are measured.
    """

    size: tuple[float, float]
    cell: float
    boxes: list[Box]
    ground: Ground
    floor: np.ndarray
    lamps: tuple[tuple[float, float], ...] = ()
    origin: Pose = ORIGIN
    corner: tuple[float, float] = (0.0, 0.0)
