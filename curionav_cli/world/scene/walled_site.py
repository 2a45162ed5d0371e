"""The site of a scene without a ROS map: a rectangular room, its floor, outer walls and lamps."""

from __future__ import annotations

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.world.scene import layout
from curionav_cli.world.scene.ground import Ground, Site
from curionav_cli.world.scene.reachability import grid_shape
from curionav_cli.world.scene.scene_format import Room, value
from curionav_cli.world.settings import Env

LAMP_SPACING, LAMPS = 2.5, 10_000  # metres; a building of 250 x 250 m


def walled_site(env: Env, rooms: tuple[Room, ...], source: str) -> Site:
    """An empty room of the scene's size; lamps in the middle of each room, or on a grid. Raises SceneError."""
    width, depth = size = value(env.size, "Pair", source, "size")
    cell = float(env.cell or 0.0)
    rows, columns = grid_shape(size, cell)
    if max(abs(rows * cell - depth), abs(columns * cell - width)) > 1e-6:
        raise SceneError(f"{source}: size {width:g} x {depth:g} m is no whole number of {cell:g} m cells.")
    x, y = np.meshgrid((np.arange(columns) + 0.5) * cell, (np.arange(rows) + 0.5) * cell)
    materials = tuple(dict.fromkeys(["planks", *(room.floor for room in rooms)]))
    index, floor = np.zeros((rows, columns), np.int64), np.zeros((rows, columns), bool)
    for room in reversed(rooms):
        x0, y0, x1, y1 = room.rect
        inside = (x > x0) & (x < x1) & (y > y0) & (y < y1)
        index[inside], floor[inside] = materials.index(room.floor), True
    lit = [room.rect for room in rooms] or [(0.0, 0.0, width, depth)]
    lights = () if env.lamps else _room_lamps(lit, source)
    return Site(size, cell, layout.shell(size, env.height, rooms), Ground(index, cell, materials),
                floor if rooms else ~floor, lights)


def _room_lamps(rects: list[tuple[float, ...]], source: str) -> tuple[tuple[float, float], ...]:
    lamps: list[tuple[float, float]] = []
    for x0, y0, x1, y1 in rects:
        if len(lamps) + max(1.0, (x1 - x0) / LAMP_SPACING) * max(1.0, (y1 - y0) / LAMP_SPACING) > LAMPS:
            raise SceneError(f"{source}: with a lamp every {LAMP_SPACING:g} m its rooms have more than {LAMPS}. "
                             "Make them smaller, or say where the lamps hang, as lamps: [[x, y], ...].")
        across, along = (max(1, round(length / LAMP_SPACING)) for length in (x1 - x0, y1 - y0))
        lamps += [(x0 + (i + 0.5) * (x1 - x0) / across, y0 + (j + 0.5) * (y1 - y0) / along)
                  for j in range(along) for i in range(across)]
    return tuple(lamps)
