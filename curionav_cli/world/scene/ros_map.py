"""ROS maps as scenes: a YAML file and its image, read cell by cell as Nav2 reads them.

Follows nav2_map_server (main a3a9704, src/map_io.cpp): row 0 of the image is the top; p = 1 - shade, or shade if
`negate`; trinary: occupied if p >= occupied_thresh, free if p <= free_thresh, else unknown, all in float32.
Unknown is an obstacle, and so is everything outside the image and every free cell that the robot cannot
reach. The world is simulated in image axes: the origin's yaw, which Nav2's costmap ignores too, is kept in the plan.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from scipy import ndimage

from curionav_cli.errors import MapError
from curionav_cli.records import Pose
from curionav_cli.world.scene.ground import Site, highest
from curionav_cli.world.scene.map_file import MapFile, MapWarning, read_map_file
from curionav_cli.world.scene.map_furnishing import furnish
from curionav_cli.world.scene.map_greys import BLOCK
from curionav_cli.world.scene.map_image import read_image
from curionav_cli.world.scene.reachability import CELLS, clearance, largest_component, whole_cells
from curionav_cli.world.scene.scene_file import Lists
from curionav_cli.world.settings import Env

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
TRAP_GREY = 205  # map_saver's grey for unknown; p = 0.19608
TRAP_SHARE = 0.005
MARGIN = 1.0  # metres of the unknown that a cropped map keeps around what was explored
MOST_CELLS = 25_000_000  # a quarter of a kilometre square in cells of 5 cm
COARSER = (0.1, 0.2, 0.5, 1.0, 2.0)  # metres; what is proposed instead


@dataclass(frozen=True)
class RosMap:
    """An occupancy grid. cells (rows, columns) int8: FREE, OCCUPIED, UNKNOWN or 1..99; row 0 is the lowest.

    origin: of the lower-left corner; corner: where in the image that is, metres from the image's own.
    """

    cells: np.ndarray
    resolution: float
    origin: Pose
    corner: tuple[float, float] = (0.0, 0.0)


def read_map(path: Path, unknown_grey: int | None = None) -> RosMap:
    """Read the whole occupancy grid of a YAML file. Raises MapError. unknown_grey: a grey to read as unknown."""
    spec = read_map_file(path)
    image = read_image(spec.image)
    occupancy = _occupancy_of_greys(spec)
    if unknown_grey is not None:
        occupancy[unknown_grey] = UNKNOWN
    cells = cv2.LUT(image.grey, occupancy)
    if image.clear is not None and spec.mode != "raw":
        cells[image.clear] = UNKNOWN
    if unknown_grey is None and FREE <= occupancy[TRAP_GREY] < OCCUPIED and _trapped(image.grey, cells) > TRAP_SHARE:
        where = f"mode {spec.mode}" if spec.mode == "scale" else f"free_thresh {spec.free:g}"
        warnings.warn(f"{path}: grey {TRAP_GREY} usually means unknown, and with {where} it is free. "
                      f"Set env.unknown_grey={TRAP_GREY} if rooms run out into the unknown.", MapWarning, stacklevel=2)
    spec.warn_of_rounding(max(cells.shape))
    return RosMap(cells[::-1], spec.resolution, spec.origin)


def _occupancy_of_greys(spec: MapFile) -> np.ndarray:
    """(256,) int8: occupancy by grey, in mode trinary, scale (0 to 100 between the thresholds) or raw (the grey)."""
    grey = np.arange(256)
    if spec.mode == "raw":
        return np.where(grey <= OCCUPIED, grey, UNKNOWN).astype(np.int8)
    shade = grey.astype(np.float32) / np.float32(255)
    p = shade if spec.negate else np.float32(1) - shade
    most, least = np.float32(spec.occupied), np.float32(spec.free)
    between = np.full(256, UNKNOWN)
    if spec.mode == "scale" and least < most:
        share = (p - least) / np.float32(spec.occupied - spec.free) * np.float32(100)
        between = np.floor(share.clip(0, 100).astype(np.float64) + 0.5)
    return np.where(p <= least, FREE, np.where(p >= most, OCCUPIED, between)).astype(np.int8)


def _trapped(grey: np.ndarray, cells: np.ndarray) -> float:
    """The share of free cells of the grey that usually means unknown."""
    parts = ((grey.reshape(-1)[at:at + BLOCK], cells.reshape(-1)[at:at + BLOCK]) for at in range(0, grey.size, BLOCK))
    return sum(np.count_nonzero((shade == TRAP_GREY) & (cell >= FREE)) for shade, cell in parts) / max(1, grey.size)


def explored_map(env: Env) -> RosMap:
    """Read the map of env.map, cropped to its explored part if it is larger than CELLS. Raises MapError."""
    assert env.map is not None
    path = Path(env.map).expanduser()
    ros = read_map(path, env.unknown_grey)
    if ros.cells.size > CELLS:
        ros = _cropped(ros, env.cell or ros.resolution)
    rows, columns = ros.cells.shape
    width, depth, cell = columns * ros.resolution, rows * ros.resolution, env.cell or ros.resolution
    if not width / cell * (depth / cell) <= MOST_CELLS:
        enough = next((side for side in COARSER if side > cell and width * depth / side**2 <= MOST_CELLS), None)
        cure = f"Set env.cell={enough:g}." if enough else "No robot explores so much."
        raise MapError(f"{path}: what was explored, {width:g} x {depth:g} m in cells of {cell:g} m, is more than "
                       f"{MOST_CELLS} cells. {cure}")
    return ros


def _cropped(ros: RosMap, cell: float) -> RosMap:
    """Crop unknown margins; the crop begins a whole number of coverage cells from the image's corner."""
    explored = [np.flatnonzero((ros.cells != UNKNOWN).any(axis=1 - axis)) for axis in (0, 1)]
    if not len(explored[0]):
        return ros
    margin, step = math.ceil(MARGIN / ros.resolution), max(1, round(cell / ros.resolution))
    (row, above), (column, right) = ((max(0, int(at[0]) - margin) // step * step, int(at[-1]) + 1 + margin)
                                     for at in explored)
    x, y = column * ros.resolution, row * ros.resolution
    sin, cos = math.sin(ros.origin.yaw), math.cos(ros.origin.yaw)
    origin = Pose(ros.origin.x + cos * x - sin * y, ros.origin.y + sin * x + cos * y, ros.origin.yaw)
    return RosMap(ros.cells[row:above, column:right].copy(), ros.resolution, origin, (x, y))


def map_site(ros: RosMap, env: Env, lists: Lists) -> Site:
    """The site of a ROS map, furnished by the lists and by guesses. Raises MapError."""
    free = (ros.cells >= FREE) & (ros.cells < env.scale_occupied)
    if not free.any():
        raise MapError(f"{env.map}: the map has no free cell, so there is nothing to explore. "
                       "Check its thresholds and negate.")
    free = _reachable_part(free, ros.resolution, env)
    rows, columns = free.shape
    size = (columns * ros.resolution, rows * ros.resolution)
    cell = env.cell or ros.resolution
    room = _at_centres(free, ros.resolution, whole_cells(size, cell), cell)
    boxes, ground, lamps = furnish(free, ros.resolution, env.height, lists)
    occupancy = highest(ros.cells, ros.resolution, room.shape, cell)
    return Site(size, cell, boxes, ground, floor=room, lamps=lamps, origin=ros.origin, corner=ros.corner,
                occupancy=occupancy, solid=occupancy >= env.scale_occupied)


def _reachable_part(free: np.ndarray, resolution: float, env: Env) -> np.ndarray:
    """The connected free cells around the start, or around the largest part that the robot fits into."""
    label, _ = ndimage.label(free)
    if env.start is not None:
        row, column = (math.floor(at / resolution) for at in (env.start[1], env.start[0]))
        if 0 <= row < free.shape[0] and 0 <= column < free.shape[1] and free[row, column]:
            return label == label[row, column]
    wide = clearance(free) > env.radius / resolution + 0.5
    seed = np.argmax(largest_component(wide if wide.any() else free))
    return label == label.flat[seed]


def _at_centres(mask: np.ndarray, resolution: float, shape: tuple[int, int], cell: float) -> np.ndarray:
    """The mask at the centres of a grid of `cell` metres."""
    if cell == resolution:
        return mask.copy()
    row, column = (np.minimum(((np.arange(n) + 0.5) * cell / resolution).astype(int), most - 1)
                   for n, most in zip(shape, mask.shape, strict=True))
    return mask[np.ix_(row, column)]
