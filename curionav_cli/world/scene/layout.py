"""From the lists of a scene file to boxes: outer walls, inner walls with doors, furniture, posters."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.world.scene.boxes import EAST, FIXED, NORTH, SOUTH, WEST, Box
from curionav_cli.world.scene.furniture import KINDS, faces, turned
from curionav_cli.world.scene.ground import Rug
from curionav_cli.world.scene.scene_format import Furniture, Poster, Room, Wall

SHELL = 0.1  # thickness of the outer walls, which stand outside the scene's size
DOOR = 2.0  # clear height of a gap without a third number
WINDOW = (0.9, 2.0)  # sill and top of a window without them
PLAIN = Room((0.0, 0.0, 0.0, 0.0))
FACES = {"west": WEST, "east": EAST, "south": SOUTH, "north": NORTH}
DECAL = 0.01


def room_at(rooms: tuple[Room, ...], x: float, y: float) -> Room:
    """The first room that contains a point, metres; PLAIN outside of all."""
    for room in rooms:
        x0, y0, x1, y1 = room.rect
        if x0 <= x <= x1 and y0 <= y <= y1:
            return room
    return PLAIN


def shell(size: tuple[float, float], height: float, rooms: tuple[Room, ...]) -> list[Box]:
    """The outer walls, cut where the rooms change so that each stretch has its room's material."""
    return [box for axis in (0, 1) for box in _shell_along(axis, size, height, rooms)]


def _shell_along(axis: int, size: tuple[float, float], height: float, rooms: tuple[Room, ...]) -> list[Box]:
    length, across = size[axis], size[1 - axis]
    boxes = []
    for low, high, inner in ((-SHELL, 0.0, 1e-6), (across, across + SHELL, across - 1e-6)):
        for start, end, material in _stretches(axis, length, inner, rooms):
            first = _xy(axis, start - SHELL * (start == 0.0) * axis, low)
            last = _xy(axis, end + SHELL * (end == length) * axis, high)
            boxes.append(Box((*first, 0.0), (*last, height), (material,) * 4, material))
    return boxes


def _stretches(axis: int, length: float, inner: float,
               rooms: tuple[Room, ...]) -> list[tuple[float, float, str]]:
    """(start, end, material) along a side whose rooms are seen at `inner` across it."""
    cuts = sorted({0.0, length} | {min(max(room.rect[i], 0.0), length) for room in rooms
                                   for i in (axis, axis + 2)})
    found: list[tuple[float, float, str]] = []
    for start, end in pairwise(cuts):
        material = room_at(rooms, *_xy(axis, 0.5 * (start + end), inner)).wall
        if found and found[-1][2] == material:
            start = found.pop()[0]
        found.append((start, end, material))
    return found


def wall(spec: Wall, height: float, rooms: tuple[Room, ...], source: str, where: str) -> list[Box]:
    """The boxes of one inner wall: its stretches, lintels and sills. Raises SceneError naming `where`."""
    axis, start, end, middle = _line(spec, source, where)
    top = spec.height or height
    if {len(gap) for gap in spec.gaps} - {2, 3} or {len(hole) for hole in spec.windows} - {2, 4}:
        raise SceneError(f"{source}: {where}: a gap is [at, width, height], a window [at, width, sill, top].")
    for key, holes in (("gaps", spec.gaps), ("windows", spec.windows)):
        for index, hole in enumerate(holes):
            if hole[1] <= 0:
                raise SceneError(f"{source}: {where}.{key}[{index}]: its width must be more than 0, not {hole[1]:g}.")
    openings = [(gap[0], gap[1], 0.0, *(gap[2:] or (DOOR,))) for gap in spec.gaps]
    openings += [(hole[0], hole[1], *(hole[2:] or WINDOW)) for hole in spec.windows]
    stretches, at = [], start
    for offset, width, sill, lintel in sorted(openings):
        first, last = start + offset, start + offset + width
        if first < at - 1e-9 or last > end + 1e-9:
            raise SceneError(f"{source}: {where} has an opening from {offset:g} to {offset + width:g} m that "
                             f"leaves the wall ({end - start:g} m long) or overlaps another.")
        stretches += [(at, first, 0.0, top), (first, last, 0.0, sill), (first, last, lintel, top)]
        at = last
    stretches.append((at, end, 0.0, top))
    return [_stretch(spec, axis, middle, piece, rooms) for piece in stretches
            if piece[1] - piece[0] > 1e-9 and piece[3] - piece[2] > 1e-9]


def _line(spec: Wall, source: str, where: str) -> tuple[int, float, float, float]:
    if len(spec.line) != 4 or (spec.line[0] != spec.line[2]) == (spec.line[1] != spec.line[3]):
        raise SceneError(f"{source}: {where}.line must run along x or along y: [x0, y0, x1, y1].")
    x0, y0, x1, y1 = spec.line
    return (0, min(x0, x1), max(x0, x1), y0) if y0 == y1 else (1, min(y0, y1), max(y0, y1), x0)


def _stretch(spec: Wall, axis: int, middle: float, piece: tuple[float, float, float, float],
             rooms: tuple[Room, ...]) -> Box:
    start, end, bottom, top = piece
    half, centre = 0.5 * spec.thickness, 0.5 * (start + end)
    below = spec.material or room_at(rooms, *_xy(axis, centre, middle - half - 0.05)).wall
    above = spec.material or room_at(rooms, *_xy(axis, centre, middle + half + 0.05)).wall
    sides = (below, below, below, above) if axis == 0 else (below, above, below, below)
    low, high = _xy(axis, start, middle - half), _xy(axis, end, middle + half)
    return Box((*low, bottom), (*high, top), sides, below)


def _xy(axis: int, along: float, across: float) -> tuple[float, float]:
    """A point given along and across an axis, as x and y."""
    return (along, across) if axis == 0 else (across, along)


def poster(spec: Poster, source: str, where: str) -> Box:
    """A decal box of 1 cm on a wall. Raises SceneError naming `where`."""
    if spec.face not in FACES:
        raise SceneError(f"{source}: {where}.face must be one of {', '.join(FACES)}, not {spec.face}.")
    x, y = spec.at
    half = 0.5 * spec.width
    low, high = {
        "west": ((x - DECAL, y - half), (x, y + half)), "east": ((x, y - half), (x + DECAL, y + half)),
        "south": ((x - half, y - DECAL), (x + half, y)), "north": ((x - half, y), (x + half, y + DECAL)),
    }[spec.face]
    return Box((*low, spec.z), (*high, spec.z + spec.height), (spec.art,) * 4, "metal", fit=True, decal=True)


def complete(spec: Furniture, source: str, where: str) -> Furniture:
    """Fill in the size and material of a piece's kind where it names none. Raises SceneError naming `where`."""
    if spec.kind not in KINDS:
        raise SceneError(f"{source}: {where}.kind: there is no furniture {spec.kind}. "
                         f"There is {', '.join(sorted(KINDS))}.")
    if spec.turn not in (0, 90, 180, 270):
        raise SceneError(f"{source}: {where}.turn must be 0, 90, 180 or 270, not {spec.turn}.")
    kind = KINDS[spec.kind]
    return replace(spec, w=spec.w or kind.w, d=spec.d or kind.d, h=spec.h or kind.h,
                   material=spec.material or kind.material)


def furniture(spec: Furniture, item: int = FIXED) -> list[Box]:
    """The boxes of a complete piece."""
    boxes = []
    for part in KINDS[spec.kind].parts(spec.w, spec.d, spec.h, spec.material):
        x0, x1, y0, y1 = np.round(turned(part, spec.w, spec.d, spec.turn), 9).tolist()
        sides, top = faces(part[6], spec.turn)
        boxes.append(Box((spec.x + x0, spec.y + y0, spec.z + part[4]),
                         (spec.x + x1, spec.y + y1, spec.z + part[5]), sides, top, fit=part[7], item=item))
    return boxes


def rug(spec: Furniture) -> Rug:
    """The rectangle of floor that a rug covers."""
    x0, x1, y0, y1 = turned((0, spec.w, 0, spec.d, 0, 0, "", False), spec.w, spec.d, spec.turn)
    return Rug((spec.x + x0, spec.y + y0), (spec.x + x1, spec.y + y1), spec.material)
