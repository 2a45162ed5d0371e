"""A robot's own map as a world: the YAML and image of ROS map_server.

Follows wiki.ros.org/map_server and nav2_map_server: row 0 of the image is the top; p = 1 - shade, or
shade if `negate`; trinary: occupied if p > occupied_thresh, free if p < free_thresh, else unknown.
Unknown is an obstacle, and so is everything outside the image and every free cell that the robot cannot
reach. The world is simulated in image axes: the origin's yaw, which ROS ignores too, is kept in the plan.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy import ndimage

from curionav_cli.config.bombs import refuse_bomb
from curionav_cli.config.schema import Env
from curionav_cli.errors import MapError
from curionav_cli.records import Pose
from curionav_cli.world.dressing import dress
from curionav_cli.world.ground import Site, highest
from curionav_cli.world.image_file import Picture, read_image
from curionav_cli.world.scene_file import Lists
from curionav_cli.world.visitable import grid_shape, largest_component

FREE, OCCUPIED, UNKNOWN = 0, 100, -1
IMAGES = (".pgm", ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".gif", ".ppm")
TRAP_GREY = 205  # map_saver's grey for unknown; p = 0.19608
TRAP_SHARE = 0.005
BLOCK = 2**16  # pixels that are looked up at once: numpy makes eight bytes of every index
HALF = 50  # in the modes scale and raw, an occupancy from here on is an obstacle


class MapWarning(UserWarning):
    """A map that opens, and may not mean what it says."""


@dataclass(frozen=True)
class RosMap:
    """cells (rows, columns) int8: FREE, OCCUPIED, UNKNOWN or 1..99; row 0 is the lowest."""

    cells: np.ndarray
    resolution: float
    origin: Pose


def open_map(env: Env, lists: Lists) -> Site:
    """The world in env.map, dressed as the lists say and as can be guessed. Raises MapError."""
    assert env.map is not None
    path = Path(env.map).expanduser()
    ros = read_map(path, env.unknown_grey)
    free = (ros.cells >= FREE) & (ros.cells < HALF)
    if not free.any():
        raise MapError(f"{path}: the map has no free cell, so there is nothing to explore. "
                       "Check its thresholds and negate.")
    free = _explored_part(free, ros.resolution, env)
    rows, columns = free.shape
    size = (columns * ros.resolution, rows * ros.resolution)
    cell = env.cell or ros.resolution
    room = _at_centres(free, ros.resolution, grid_shape(size, cell), cell)
    boxes, ground, lamps = dress(free, ros.resolution, env.height, lists)
    occupancy = highest(ros.cells, ros.resolution, room.shape, cell)
    return Site(size, cell, boxes, ground, floor=room, lamps=lamps, origin=ros.origin, occupancy=occupancy,
                solid=occupancy >= HALF)


def read_map(path: Path, unknown_grey: int | None = None) -> RosMap:
    """The occupancy grid that this YAML file describes. Raises MapError."""
    spec = _specification(path)
    image = path.parent / str(spec["image"])
    if not image.is_file():
        raise MapError(f"{path}: its image {image} does not exist. The path is relative to the YAML file.")
    resolution = _number(spec["resolution"], path, "resolution")
    if resolution <= 0.0:
        raise MapError(f"{path}: resolution is {resolution:g}; it is metres per pixel, more than 0.")
    picture = read_image(image)
    cells, trapped = _occupancy(picture, spec, path, unknown_grey)
    if unknown_grey is None and trapped > TRAP_SHARE:
        warnings.warn(f"{path}: grey {TRAP_GREY} usually means unknown, and free_thresh "
                      f"{spec.get('free_thresh', 0.196)} makes it free. Set env.unknown_grey={TRAP_GREY} "
                      "if rooms run out into the unknown.", MapWarning, stacklevel=2)
    return RosMap(cells[::-1], resolution, _origin(spec["origin"], path))


def _specification(path: Path) -> dict[str, Any]:
    if path.suffix.lower() in IMAGES:
        raise MapError(f"{path} is an image. Give the map's YAML file, which names its image, resolution and "
                       f"origin (usually {path.with_suffix('.yaml').name} beside it).")
    if not path.is_file():
        raise MapError(f"There is no map {path}. env.map is the path of a ROS map's YAML file.")
    try:
        text = path.read_text(encoding="utf-8")
        refuse_bomb(text)
        spec = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError):
        raise MapError(f"{path} is not YAML, so it is no ROS map.") from None
    found = spec if isinstance(spec, dict) else {}
    missing = [key for key in ("image", "resolution", "origin") if key not in found]
    if missing:
        raise MapError(f"{path} is no ROS map: it lacks {', '.join(missing)}.")
    return found


def _number(raw: Any, path: Path, key: str) -> float:
    if isinstance(raw, bool) or not isinstance(raw, int | float) or not math.isfinite(raw):
        raise MapError(f"{path}: {key} must be a number, not {raw!r}.")
    return float(raw)


def _origin(raw: Any, path: Path) -> Pose:
    if not isinstance(raw, list) or len(raw) not in (2, 3):
        raise MapError(f"{path}: origin must be [x, y, yaw], not {raw!r}.")
    return Pose(*(_number(part, path, "origin") for part in [*raw, 0.0][:3]))


def _occupancy(picture: Picture, spec: dict[str, Any], path: Path, unknown: int | None) -> tuple[np.ndarray, float]:
    """(rows, columns) int8, row 0 on top, and the share of it that is free and of the grey that is usually unknown."""
    mode = spec.get("mode", "trinary")
    weighed = mode == "trinary" and picture.alpha is not None  # map_server averages alpha in as one more channel
    white = picture.white + weighed * picture.opaque
    meaning = _meaning(np.arange(white + 1) / white, mode, spec, path)
    greys = np.rint(np.arange(picture.white + 1) / picture.white * 255.0).astype(np.int64)
    cells, trapped = np.empty(picture.level.size, np.int8), 0
    for at in range(0, cells.size, BLOCK):
        here = slice(at, at + BLOCK)
        level = np.minimum(picture.level.reshape(-1)[here], picture.white)
        alpha = None if picture.alpha is None else picture.alpha.reshape(-1)[here]
        part, grey = meaning[level + alpha if weighed else level], greys[level]
        if mode == "scale" and alpha is not None:
            part[alpha < picture.opaque] = UNKNOWN
        trapped += int(((grey == TRAP_GREY) & (part == FREE)).sum())
        part[grey == unknown] = UNKNOWN
        cells[here] = part
    return cells.reshape(picture.level.shape), trapped / cells.size


def _meaning(shade: np.ndarray, mode: Any, spec: dict[str, Any], path: Path) -> np.ndarray:
    """int8 of each shade, as the mode says: trinary, scale (1 to 99 between), raw (the grey itself)."""
    negate = bool(spec.get("negate", 0))
    if mode == "raw":
        value = np.rint(shade * 255.0)
        return np.where(value <= OCCUPIED, value, UNKNOWN).astype(np.int8)
    if mode not in ("trinary", "scale"):
        raise MapError(f"{path}: mode must be trinary, scale or raw, not {mode!r}.")
    most = _number(spec.get("occupied_thresh", 0.65), path, "occupied_thresh")
    least = _number(spec.get("free_thresh", 0.196), path, "free_thresh")
    if least >= most:
        raise MapError(f"{path}: free_thresh {least:g} must be below occupied_thresh {most:g}.")
    p = shade if negate else 1.0 - shade
    between = UNKNOWN if mode == "trinary" else 1 + np.floor(98.0 * (p - least) / (most - least))
    return np.where(p > most, OCCUPIED, np.where(p < least, FREE, between)).astype(np.int8)


def _explored_part(free: np.ndarray, resolution: float, env: Env) -> np.ndarray:
    """The connected free cells around the start, or around the largest part that the robot fits into."""
    label, _ = ndimage.label(free)
    if env.start is not None:
        row, column = (math.floor(at / resolution) for at in (env.start[1], env.start[0]))
        if 0 <= row < free.shape[0] and 0 <= column < free.shape[1] and free[row, column]:
            return label == label[row, column]
    room = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] * resolution
    wide = room > env.radius + resolution / 2
    seed = np.argmax(largest_component(wide if wide.any() else free))
    return label == label.flat[seed]


def _at_centres(mask: np.ndarray, resolution: float, shape: tuple[int, int], cell: float) -> np.ndarray:
    """The mask at the centres of a grid of `cell` metres."""
    if cell == resolution:
        return mask.copy()
    row, column = (np.minimum(((np.arange(n) + 0.5) * cell / resolution).astype(int), most - 1)
                   for n, most in zip(shape, mask.shape, strict=True))
    return mask[np.ix_(row, column)]
