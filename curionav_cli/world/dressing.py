"""What a 2-D map lacks: heights, colours, floors, lamps. Seeded by the map, so it is always the same.

Rooms are guessed from the widths of the free space; each gets its own walls and floor. Small solid
islands become furniture of their own height and material, long walls get posters and windows.
"""

from __future__ import annotations

import zlib

import numpy as np
from scipy import ndimage

from curionav_cli.world.boxes import EAST, NORTH, SOUTH, WEST, Box
from curionav_cli.world.ground import Ground
from curionav_cli.world.layout import poster
from curionav_cli.world.meshing import mesh
from curionav_cli.world.scene_format import Poster

WALLS = ("plaster_white", "plaster_sand", "plaster_sage", "plaster_blue", "plaster_rose", "brick",
         "stripe_blue", "stripe_green", "plaster_grey", "brick_white", "panel", "plaster_ochre")
FLOORS = ("planks", "tiles_grey", "carpet_blue", "parquet", "tiles_cream", "carpet_green", "concrete",
          "carpet_red", "planks_dark")
ISLANDS = (("doors", 0.9), ("drawers", 0.8), ("fabric_blue", 0.7), ("books", 1.6), ("wood_oak", 0.74),
           ("fabric_green", 0.75), ("cardboard", 0.6), ("kitchen", 0.9), ("fabric_red", 0.7))
ART = ("poster_1", "poster_2", "poster_3", "poster_4", "poster_5", "poster_6", "window")
WINDOW, LARGE, SMALL = (0.9, 1.0, 0.9), (0.6, 0.8, 0.8), (0.4, 0.5, 0.9)  # width, height, lower edge
POST = ("wood_dark", 0.75)  # an island of one or two cells: the leg of a table or chair
WIDTHS = (1.5, 0.95, 0.55)  # metres from the walls: rooms are told apart where the space between is narrower
LONGEST = 4.0
ISLAND = 2.2
POST_SIZE = 0.16
POSTER_SPACING = 2.6
SHORT, SHORTEST = 1.3, 0.45  # faces for small posters only, and for none
LAMP_SPACING = 2.4


def dress(free: np.ndarray, resolution: float,
          height: float) -> tuple[list[Box], Ground, tuple[tuple[float, float], ...]]:
    """Boxes, floor and lamps for the free cells (rows, columns) of a map with `resolution` m cells."""
    rng = np.random.default_rng(zlib.crc32(np.packbits(free).tobytes()))
    room = rooms(free, resolution)
    wall_of = rng.permutation(len(WALLS))[np.arange(room.max() + 2) % len(WALLS)]
    floor_of = rng.permutation(len(FLOORS))[np.arange(room.max() + 2) % len(FLOORS)]
    islands, material, tall = _islands(~free, resolution, height, rng)
    padded = np.pad(room, 1, constant_values=-1)
    boxes: list[Box] = []
    for r0, c0, r1, c1 in mesh(~free, max(1, round(LONGEST / resolution))).tolist():
        island = islands[r0, c0]
        low, high = (c0 * resolution, r0 * resolution), (c1 * resolution, r1 * resolution)
        if island:
            boxes.append(Box((*low, 0.0), (*high, tall[island]), (material[island],) * 4, material[island]))
            continue
        beside = _rooms_beside(padded, r0, c0, r1, c1)
        sides = tuple(WALLS[wall_of[number]] for number in beside)
        boxes.append(Box((*low, 0.0), (*high, height), sides, sides[0]))  # type: ignore[arg-type]
        boxes += _posters(room, (r0, c0, r1, c1), resolution, rng)
    ground = Ground(floor_of[np.maximum(room, 0)], resolution, FLOORS)
    return boxes, ground, _lamps(free, resolution)


def rooms(free: np.ndarray, resolution: float) -> np.ndarray:
    """A guess at the rooms: (rows, columns) int, a number for each free cell, -1 for solid ones."""
    width = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] * resolution
    core = np.zeros(free.shape, np.int64)
    for threshold in WIDTHS:
        part, count = ndimage.label(width > threshold)
        core = np.where(width > threshold, _grown(core, part, count), 0)
    if not core.any():
        return np.where(free, 0, -1)
    nearest = ndimage.distance_transform_edt(core == 0, return_distances=False, return_indices=True)
    return np.where(free, core[tuple(nearest)] - 1, -1)


def _grown(core: np.ndarray, part: np.ndarray, count: int) -> np.ndarray:
    """Rooms found where it is wider, spread over their part; a part without any becomes a room."""
    known = np.unique(part[core > 0])
    fresh = np.setdiff1d(np.arange(1, count + 1), known)
    number = np.zeros(count + 1, np.int64)
    number[fresh] = core.max() + 1 + np.arange(len(fresh))
    nearest = ndimage.distance_transform_edt(core == 0, return_distances=False, return_indices=True)
    spread = core[tuple(nearest)] if core.any() else core
    return np.where(np.isin(part, fresh), number[part], spread)


def _islands(solid: np.ndarray, resolution: float, height: float,
             rng: np.random.Generator) -> tuple[np.ndarray, list[str], list[float]]:
    """Small solid islands: their numbers (0: a wall), and the material and height of each."""
    label, count = ndimage.label(solid, np.ones((3, 3)))
    material, tall = [""] * (count + 1), [height] * (count + 1)
    for number, (rows, columns) in enumerate(ndimage.find_objects(label), start=1):
        extent = max(rows.stop - rows.start, columns.stop - columns.start) * resolution
        outside = min(rows.start, columns.start) == 0 or (rows.stop, columns.stop) == solid.shape
        if extent > ISLAND or outside:
            label[rows, columns][label[rows, columns] == number] = 0
            continue
        name, top = POST if extent <= POST_SIZE else ISLANDS[rng.integers(len(ISLANDS))]
        material[number], tall[number] = name, min(top, height)
    return label, material, tall


def _rooms_beside(padded: np.ndarray, r0: int, c0: int, r1: int, c1: int) -> list[int]:
    """The room that each face looks at, west east south north; a hidden face takes any other's.

    padded: the rooms' numbers with a border of one cell.
    """
    strips = (padded[r0 + 1:r1 + 1, c0], padded[r0 + 1:r1 + 1, c1 + 1],
              padded[r0, c0 + 1:c1 + 1], padded[r1 + 1, c0 + 1:c1 + 1])
    most = [int(np.bincount(strip + 1, minlength=2)[1:].argmax()) if (strip >= 0).any() else -1
            for strip in strips]
    return [number if number >= 0 else max(most) for number in most]


def _posters(room: np.ndarray, cells: tuple[int, int, int, int], resolution: float,
             rng: np.random.Generator) -> list[Box]:
    """Pictures and windows on the long faces of one wall that look at a room."""
    r0, c0, r1, c1 = cells
    found = []
    for face, first, last, line, name in ((SOUTH, c0, c1, r0 - 1, "south"), (NORTH, c0, c1, r1, "north"),
                                          (WEST, r0, r1, c0 - 1, "west"), (EAST, r0, r1, c1, "east")):
        upright = face in (WEST, EAST)
        if not 0 <= line < room.shape[upright]:
            continue
        strip = (room[:, line] if upright else room[line])[first:last]
        at = (line + (name in ("south", "west"))) * resolution
        small = len(strip) * resolution < SHORT
        for along in _places(strip >= 0, resolution, rng):
            art = ART[rng.integers(len(ART) - small)]
            width, tall, z = WINDOW if art == "window" else SMALL if small else LARGE
            middle = first * resolution + along
            spot = (at, middle) if upright else (middle, at)
            found.append(poster(Poster(spot, name, art, width, tall, z), "map", "poster"))
    return found


def _places(seen: np.ndarray, resolution: float, rng: np.random.Generator) -> list[float]:
    """Where along a face pictures hang: about every POSTER_SPACING, where a metre of it is seen."""
    length = len(seen) * resolution
    if length < SHORT:
        return [length / 2] if length >= SHORTEST and seen.all() and rng.random() < 0.4 else []
    places = []
    for along in np.arange(0.7 + rng.uniform(0.0, 0.8), length - 0.6, POSTER_SPACING):
        first, last = (int((along + side) / resolution) for side in (-0.5, 0.5))
        if seen[first:last + 1].all() and rng.random() < 0.8:
            places.append(float(along))
    return places


def _lamps(free: np.ndarray, resolution: float) -> tuple[tuple[float, float], ...]:
    """Ceiling lamps on a grid, where the free space is wide enough."""
    width = ndimage.distance_transform_edt(np.pad(free, 1))[1:-1, 1:-1] * resolution
    step = max(1, round(LAMP_SPACING / resolution))
    rows, columns = np.nonzero(width[step // 2::step, step // 2::step] > 0.4)
    x, y = ((at * step + step // 2 + 0.5) * resolution for at in (columns, rows))
    return tuple(zip(x.tolist(), y.tolist(), strict=True))
