"""Guesses at what a 2-D map does not hold: heights, colours, floors, lamps. Seeded by the map, so always the same.

Rooms are guessed from the widths of the free space; each gets its own walls and floor. Small solid
islands become furniture of their own height and material, long walls get posters and windows.
"""

from __future__ import annotations

import math
import zlib

import numpy as np
from scipy import ndimage

from curionav_cli.world.scene.boxes import EAST, NORTH, SOUTH, WEST, Box
from curionav_cli.world.scene.ground import Ground
from curionav_cli.world.scene.layout import PLAIN, poster, room_at
from curionav_cli.world.scene.reachability import CELLS, clearance
from curionav_cli.world.scene.rectangle_cover import cover, widened
from curionav_cli.world.scene.scene_file import Lists
from curionav_cli.world.scene.scene_format import Poster, Room, Solid

WALLS = ("plaster_white", "plaster_sand", "plaster_sage", "plaster_blue", "plaster_rose", "brick",
         "stripe_blue", "stripe_green", "plaster_grey", "brick_white", "panel", "plaster_ochre")
FLOORS = ("planks", "tiles_grey", "carpet_blue", "parquet", "tiles_cream", "carpet_green", "concrete",
          "carpet_red", "planks_dark")
ISLANDS = (("doors", 0.9), ("drawers", 0.8), ("fabric_blue", 0.7), ("books", 1.6), ("wood_oak", 0.74),
           ("fabric_green", 0.75), ("cardboard", 0.6), ("kitchen", 0.9), ("fabric_red", 0.7))
ART = ("poster_1", "poster_2", "poster_3", "poster_4", "poster_5", "poster_6", "window")
WINDOW, LARGE, SMALL = (0.9, 1.0, 0.9), (0.6, 0.8, 0.8), (0.4, 0.5, 0.9)  # width, height, lower edge
POST = ("wood_dark", 0.75)  # an island of one or two cells: the leg of a table or chair
WIDTHS = (1.5, 0.95, 0.55)  # metres from the walls: rooms are separated where the space between is narrower
LONGEST = 4.0
AHEAD = 0.03  # metres before a face: the room it faces
ISLAND = 2.2
POST_SIZE = 0.16
POSTER_SPACING = 2.6
SHORT, SHORTEST = 1.3, 0.45  # faces for small posters only, and for none
LAMP_SPACING = 2.4


def furnish(free: np.ndarray, resolution: float, height: float,
          lists: Lists) -> tuple[list[Box], Ground, tuple[tuple[float, float], ...]]:
    """Boxes, floor and lamps for the free cells (rows, columns) of a map with `resolution` m cells.

    Rooms, solids and posters of `lists` replace the guesses there.
    """
    rng = np.random.default_rng(zlib.crc32(np.packbits(free).tobytes()))
    room = rooms(free, resolution)
    wall_of = rng.permutation(len(WALLS))[np.arange(room.max() + 2) % len(WALLS)]
    floor_of = rng.permutation(len(FLOORS))[np.arange(room.max() + 2) % len(FLOORS)]
    boxes, walls = _solids(~free, resolution, lists.solids)
    islands, material, tall = _islands(walls, resolution, height, rng)
    islands = np.pad(islands, (0, 1))  # 0, a wall, just outside the map: at -1 too
    padded = np.pad(room, 2, constant_values=-1)
    longest = max(1, round(LONGEST / resolution))
    pieces = np.concatenate([cover(walls, longest), _edge(free, longest)])
    for r0, c0, r1, c1 in _cut(pieces, lists.rooms, resolution):
        island = islands[r0, c0]
        low, high = (c0 * resolution, r0 * resolution), (c1 * resolution, r1 * resolution)
        if island:
            boxes.append(Box((*low, 0.0), (*high, tall[island]), (material[island],) * 4, material[island]))
            continue
        beside = _rooms_beside(padded, r0, c0, r1, c1)
        guessed = [WALLS[wall_of[number]] for number in beside]
        sides = _sides(guessed, low, high, lists.rooms)
        boxes.append(Box((*low, 0.0), (*high, height), sides, sides[0]))
        boxes += [] if lists.posters else _posters(room, (r0, c0, r1, c1), resolution, rng)
    ground = _ground(floor_of.astype(np.int16)[np.maximum(room, 0)], resolution, lists.rooms)
    return boxes, ground, _lamps(free, resolution)


def _solids(occupied: np.ndarray, resolution: float, solids: tuple[Solid, ...]) -> tuple[list[Box], np.ndarray]:
    """The boxes of what the overlay gives a height, and the occupied cells that are left."""
    boxes, left = [], occupied.copy()
    for solid in solids:
        part = left & _inside(solid.rect, left.shape, resolution)
        left &= ~part
        for r0, c0, r1, c1 in (cover(part, max(part.shape), hidden=True) * resolution).tolist():
            boxes.append(Box((c0, r0, 0.0), (c1, r1, solid.height), (solid.material,) * 4, solid.material,
                             fit=solid.fit))
    return boxes, left


def _edge(free: np.ndarray, longest: int) -> np.ndarray:
    """Rectangles as cover gives them, just outside the map where free cells touch its border."""
    beside = widened(np.pad(free, 1))
    beside[1:-1, 1:-1] = False
    return cover(beside, longest, hidden=True) - 1


def _inside(rect: tuple[float, ...], shape: tuple[int, ...], resolution: float) -> np.ndarray:
    """(rows, columns) bool: the cells whose centre lies in the rectangle."""
    y, x = ((np.arange(n) + 0.5) * resolution for n in shape)
    x0, y0, x1, y1 = rect
    return ((y > y0) & (y < y1))[:, None] & ((x > x0) & (x < x1))[None, :]


def _cut(rectangles: np.ndarray, overlay_rooms: tuple[Room, ...], resolution: float) -> list[list[int]]:
    """The rectangles, each cut where a room of the overlay begins or ends."""
    pieces: list[list[int]] = rectangles.tolist()
    for axis in (0, 1):  # rows along y, columns along x
        edges = {round(room.rect[side] / resolution) for room in overlay_rooms for side in (1 - axis, 3 - axis)}
        for at in sorted(edges):
            crossed = [piece for piece in pieces if piece[axis] < at < piece[axis + 2]]
            pieces = [piece for piece in pieces if piece not in crossed]
            for piece in crossed:
                first, second = list(piece), list(piece)
                first[axis + 2], second[axis] = at, at
                pieces += [first, second]
    return pieces


def _sides(guessed: list[str], low: tuple[float, float], high: tuple[float, float],
                overlay_rooms: tuple[Room, ...]) -> tuple[str, str, str, str]:
    """The materials of a wall's faces: those of the overlay's room that a face looks into, else the guess."""
    x, y = 0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])
    before = ((low[0] - AHEAD, y), (high[0] + AHEAD, y), (x, low[1] - AHEAD), (x, high[1] + AHEAD))
    rooms = [room_at(overlay_rooms, *at) for at in before]
    west, east, south, north = (guess if room is PLAIN else room.wall
                                for guess, room in zip(guessed, rooms, strict=True))
    return west, east, south, north


def _ground(guessed: np.ndarray, resolution: float, overlay_rooms: tuple[Room, ...]) -> Ground:
    index = guessed.copy()
    for number, room in reversed(list(enumerate(overlay_rooms))):
        index[_inside(room.rect, index.shape, resolution)] = len(FLOORS) + number
    return Ground(index, resolution, FLOORS + tuple(room.floor for room in overlay_rooms))


def rooms(free: np.ndarray, resolution: float) -> np.ndarray:
    """A guess at the rooms: (rows, columns) int, a number for each free cell, -1 for solid ones.

    A map of more than CELLS is subsampled.
    """
    box = ndimage.find_objects(free.view(np.uint8))[0]  # all free cells lie in it
    inside, number = free[box], np.full(free.shape, -1, np.int32)
    step = 1 if inside.size <= CELLS else math.ceil(2.0 * math.sqrt(inside.size / CELLS))
    nearest = _nearest_room(inside[::step, ::step], resolution * step)
    nearest = nearest.repeat(step, 0).repeat(step, 1)[:inside.shape[0], :inside.shape[1]]
    number[box] = np.where(inside, nearest, np.int32(-1))
    return number


def _nearest_room(free: np.ndarray, resolution: float) -> np.ndarray:
    """(rows, columns) int: for every cell the number of the room that is nearest."""
    away = clearance(free)
    core = np.zeros(free.shape, np.int32)
    for threshold in WIDTHS:
        wide = away * np.float64(resolution) > threshold
        part, count = ndimage.label(wide)
        core = np.where(wide, _grown(core, part, count), np.int32(0))
    del away, wide, part
    return _spread(core) - np.int32(1) if core.any() else core


def _grown(core: np.ndarray, part: np.ndarray, count: int) -> np.ndarray:
    """Rooms found where it is wider, spread over their part; a part without any becomes a room."""
    fresh = np.bincount(part[core > 0], minlength=count + 1) == 0
    fresh[0] = False
    number = np.zeros(count + 1, np.int32)
    number[fresh] = core.max() + 1 + np.arange(fresh.sum())
    return np.where(fresh[part], number[part], _spread(core) if core.any() else core)


def _spread(core: np.ndarray) -> np.ndarray:
    """The number above 0 that is nearest to each cell; there must be one."""
    rows, columns = ndimage.distance_transform_edt(core == 0, return_distances=False, return_indices=True)
    return core[rows, columns]


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
    """The room that each face adjoins, west east south north; a hidden face takes any other's.

    padded: the rooms' numbers with a border of two cells.
    """
    strips = (padded[r0 + 2:r1 + 2, c0 + 1], padded[r0 + 2:r1 + 2, c1 + 2],
              padded[r0 + 1, c0 + 2:c1 + 2], padded[r1 + 2, c0 + 2:c1 + 2])
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
        upright, first = face in (WEST, EAST), max(first, 0)
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
    step = max(1, round(LAMP_SPACING / resolution))
    width = clearance(free)[step // 2::step, step // 2::step].astype(np.float64) * resolution
    rows, columns = np.nonzero(width > 0.4)
    x, y = ((at * step + step // 2 + 0.5) * resolution for at in (columns, rows))
    return tuple(zip(x.tolist(), y.tolist(), strict=True))
