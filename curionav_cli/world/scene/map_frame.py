"""Coordinates in a cropped ROS map: start, dock and lists are measured from the corner of the whole image."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from curionav_cli.world.scene.scene_file import Lists
from curionav_cli.world.settings import Env


def shifted(env: Env, lists: Lists, corner: tuple[float, float]) -> tuple[Env, Lists]:
    """Shift all places to be measured from `corner`, metres. start, dock and lamps must have been checked."""
    if corner == (0.0, 0.0):
        return env, lists

    def at(numbers: Sequence[float]) -> tuple[float, ...]:
        return tuple(number - corner[axis % 2] for axis, number in enumerate(numbers))

    moved = replace(lists, rooms=tuple(replace(room, rect=at(room.rect)) for room in lists.rooms),
                    walls=tuple(replace(wall, line=at(wall.line)) for wall in lists.walls),
                    solids=tuple(replace(solid, rect=at(solid.rect)) for solid in lists.solids),
                    posters=tuple(replace(poster, at=at(poster.at)) for poster in lists.posters),
                    furniture=tuple(replace(piece, x=piece.x - corner[0], y=piece.y - corner[1])
                                    for piece in lists.furniture),
                    moves=tuple(replace(move, to=tuple(map(at, move.to))) for move in lists.moves))
    start, dock = ([*at(pose[:2]), pose[2]] if pose else pose for pose in (env.start, env.dock))
    return replace(env, start=start, dock=dock, lamps=[list(at(lamp)) for lamp in env.lamps]), moved
