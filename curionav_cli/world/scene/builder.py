"""Building a scene from its file: boxes, reachable cells, and the check of their promised number."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.geometry import rectangle_distance
from curionav_cli.records import FloorPlan, Pose
from curionav_cli.world.materials.materials import COLOURS, PATTERNS, exists
from curionav_cli.world.scene import layout
from curionav_cli.world.scene.boxes import FIXED, Box, Boxes
from curionav_cli.world.scene.dynamics import Item
from curionav_cli.world.scene.ground import Site
from curionav_cli.world.scene.map_frame import shifted
from curionav_cli.world.scene.overlay import overlaid
from curionav_cli.world.scene.reachability import (
    clear_cells,
    component,
    covered_cells,
    fingerprint,
    largest_component,
    roomiest,
    trimmed,
)
from curionav_cli.world.scene.ros_map import explored_map, map_site
from curionav_cli.world.scene.scene_file import Lists, collision_of, lists_of, settings
from curionav_cli.world.scene.scene_format import Furniture, value
from curionav_cli.world.scene.walled_site import walled_site
from curionav_cli.world.settings import Env, Scan

TUNE_STEPS = 200
START_ROOM = 0.1  # metres around the robot at the start into which no item may be moved


def construct(raw: dict[str, Any], source: str) -> dict[str, Any]:
    """The fields of the Scene that a dict describes. Raises SceneError or MapError naming `source`."""
    env, source = overlaid(settings(raw, source), source)
    for key in ("start", "dock"):
        if getattr(env, key) is not None:
            _pose(getattr(env, key), key, source)
    value(env.lamps, "tuple[Pair, ...]", source, "lamps")
    lists = lists_of(env, source)
    view = None
    if isinstance(env, Scan):
        from curionav_cli.world.scan.site import scan_site  # late: it loads scipy.spatial

        site, view = scan_site(env)
        env, lists = shifted(env, lists, site.corner)
    elif env.map:
        ros = explored_map(env)
        env, lists = shifted(env, lists, ros.corner)
        site = map_site(ros, env, lists)
    else:
        site = walled_site(env, lists.rooms, source)
    items = _items(lists, source)
    furniture, visitable, start = _reach(env, lists, site, items, source)
    boxes = _pack(env, lists, furniture, site, items, source)
    _keep_promise(env, visitable, source)
    _keep_start_free(env, lists, boxes, start, items, site, source)
    dock = _pose(env.dock, "dock", source) if env.dock else None
    plan = FloorPlan(visitable=visitable, floor=site.floor, solid=_solid(env, boxes, site), cell=site.cell, start=start,
                     radius=env.radius, name=env.name, map_origin=site.origin, occupancy=site.occupancy, dock=dock,
                     picture=site.picture)
    rugs = tuple(layout.rug(piece) for piece in furniture if piece.kind == "rug")
    _check_materials([*boxes.materials, *site.ground.materials, *(rug.material for rug in rugs)], source)
    return {
        "name": env.name, "note": env.note, "source": source, "size": site.size, "height": env.height,
        "camera": env.camera, "fov": env.fov, "agent_height": env.agent_height,
        "collision": collision_of(env, source), "plan": plan, "boxes": boxes,
        "ground": replace(site.ground, rugs=site.ground.rugs + rugs),
        "lamps": site.lamps + value(env.lamps, "tuple[Pair, ...]", source, "lamps"),
        "dock": dock or start,
        "light": lists.light, "moves": lists.moves, "items": items, "view": view,
    }


def _solid(env: Env, boxes: Boxes, site: Site) -> np.ndarray:
    """(rows, columns) bool: the cells under anything fixed; of a map its own cells, not the boxes that outline them."""
    fixed = boxes.solid(env.agent_height) & (boxes.item == FIXED)
    if site.solid is not None:
        fixed[:len(site.boxes)] = False  # the map's own come first
    covered = covered_cells(boxes.low[fixed, :2], boxes.high[fixed, :2], site.floor.shape, site.cell)
    return covered if site.solid is None else covered | site.solid


def _check_materials(names: list[str], source: str) -> None:
    for name in names:
        if not exists(name):
            colours, patterns = ", ".join(filter(None, COLOURS)), ", ".join(sorted(PATTERNS))
            raise SceneError(f"{source}: there is no material {name}. There is {patterns}; "
                             f"the plain ones in colours, as plaster_sage: {colours}.")


def _items(lists: Lists, source: str) -> tuple[Item, ...]:
    """The pieces that the moves name, in the order of the moves. Raises SceneError."""
    named = {piece.name: piece for piece in lists.furniture if piece.name}
    for index, move in enumerate(lists.moves):
        if move.item not in named:
            raise SceneError(f"{source}: moves[{index}].item: no piece of furniture is called {move.item}.")
        if [piece.name for piece in lists.furniture].count(move.item) > 1:
            raise SceneError(f"{source}: moves[{index}].item: more than one piece of furniture is called {move.item}.")
        if move.every < 1 or not move.to:
            raise SceneError(f"{source}: moves[{index}] needs every: 1 or more, and to: [[x, y], ...].")
    names = [move.item for move in lists.moves]
    for name in names:
        if names.count(name) > 1:
            raise SceneError(f"{source}: moves names {name} more than once; list all its places in one to:.")
    return tuple(Item(name, (named[name].x, named[name].y)) for name in names)


def _keep_start_free(env: Env, lists: Lists, boxes: Boxes, start: Pose, items: tuple[Item, ...], site: Site,
                     source: str) -> None:
    """Raise SceneError for a move that puts an item on the start."""
    for index, (move, item) in enumerate(zip(lists.moves, items, strict=True)):
        solid = boxes.solid(env.agent_height) & (boxes.item == index)
        for x, y in (item.first, *((at[0], at[1]) for at in move.to)):
            shift = np.array([x, y]) - item.first
            corners = zip(boxes.low[solid, :2] + shift, boxes.high[solid, :2] + shift, strict=True)
            point = np.array(start.x), np.array(start.y)
            if any(rectangle_distance(*point, *box) <= env.radius + START_ROOM for box in corners):
                raise SceneError(f"{source}: moves[{index}] puts {item.name} at ({x + site.corner[0]:g}, "
                                 f"{y + site.corner[1]:g}), on the start.")


def _pack(env: Env, lists: Lists, furniture: tuple[Furniture, ...], site: Site, items: tuple[Item, ...],
          source: str) -> Boxes:
    boxes: list[Box] = list(site.boxes)
    number = {item.name: index for index, item in enumerate(items)}
    for index, wall in enumerate(lists.walls):
        boxes += layout.wall(wall, env.height, lists.rooms, source, f"walls[{index}]")
    for piece in furniture:
        boxes += layout.furniture(piece, number.get(piece.name, FIXED))
    boxes += [layout.poster(poster, source, f"posters[{i}]") for i, poster in enumerate(lists.posters)]
    return Boxes.pack(boxes)


def _reach(env: Env, lists: Lists, site: Site, items: tuple[Item, ...],
           source: str) -> tuple[tuple[Furniture, ...], np.ndarray, Pose]:
    """The furniture as tuned, the reachable cells without the movable items, the start.

    With `tune`, the named piece grows by one cell at a time while at least `visitable` cells stay
    reachable, then the rest is trimmed by a fixed rule (reachability.trimmed).
    """
    furniture = lists.furniture
    visitable, start = _visitable(env, lists, furniture, site, items, source)
    if lists.tune is None or env.visitable is None or not _promise_applies(env):
        return furniture, visitable, start
    if lists.tune.piece not in {piece.name for piece in furniture} or lists.tune.axis not in ("w", "d"):
        raise SceneError(f"{source}: tune needs piece: the name of a piece of furniture, and axis: w or d.")
    for _ in range(TUNE_STEPS):
        longer = tuple(_grown(piece, lists.tune.axis, site.cell) if piece.name == lists.tune.piece else piece
                       for piece in furniture)
        fewer, _ = _visitable(env, lists, longer, site, items, source)
        if fewer.sum() < env.visitable:
            break
        furniture, visitable = longer, fewer
    if visitable.sum() > env.visitable:
        visitable = trimmed(visitable, _cell_of(start, site.cell), env.visitable)
    return furniture, visitable, start


def _grown(piece: Furniture, axis: str, by: float) -> Furniture:
    if axis == "w":
        return replace(piece, w=piece.w + by, x=piece.x + by / 2)
    return replace(piece, d=piece.d + by, y=piece.y + by / 2)


def _visitable(env: Env, lists: Lists, furniture: tuple[Furniture, ...], site: Site,
               items: tuple[Item, ...], source: str) -> tuple[np.ndarray, Pose]:
    clear = site.clear
    if clear is None:
        boxes = _pack(env, lists, furniture, site, items, source)
        solid = boxes.solid(env.agent_height) & (boxes.item == FIXED)
        clear = clear_cells(boxes.low[solid, :2], boxes.high[solid, :2], site.size, site.cell, env.radius)
        clear &= site.floor
    if not clear.any():
        raise SceneError(f"{source}: a robot of radius {env.radius:g} m fits nowhere. Lower env.radius.")
    start = _start(env, clear, site, source)
    return component(clear, *_cell_of(start, site.cell)), start


def _start(env: Env, clear: np.ndarray, site: Site, source: str) -> Pose:
    """The start in the file, or the roomiest cell of the largest component. Raises SceneError."""
    if env.start is None:
        row, column = roomiest(largest_component(clear))
        return Pose((column + 0.5) * site.cell, (row + 0.5) * site.cell, 0.0)
    start = _pose(env.start, "start", source)
    row, column = _cell_of(start, site.cell)
    rows, columns = np.nonzero(clear)
    inside = 0 <= row < clear.shape[0] and 0 <= column < clear.shape[1]
    if inside and clear[row, column]:
        return start
    x, y = (columns + 0.5) * site.cell, (rows + 0.5) * site.cell
    near = int(np.argmin(np.hypot(x - start.x, y - start.y)))
    x0, y0 = site.corner
    raise SceneError(
        f"{source}: the start ({start.x + x0:g}, {start.y + y0:g}) is inside a wall or furniture, or nearer to it than "
        f"the radius {env.radius:g} m. The nearest free spot is ({x[near] + x0:.6g}, {y[near] + y0:.6g}).")


def _pose(raw: Any, key: str, source: str) -> Pose:
    numbers = value(raw, "Numbers", source, key)
    if len(numbers) != 3 or numbers[2] % 10:
        raise SceneError(f"{source}: {key} must be [x, y, degrees], degrees a multiple of 10, not {raw}.")
    return Pose(numbers[0], numbers[1], math.radians(numbers[2] % 360))


def _cell_of(pose: Pose, cell: float) -> tuple[int, int]:
    return math.floor(pose.y / cell), math.floor(pose.x / cell)


def _promise_applies(env: Env) -> bool:
    """True where the number of visitable cells is promised: for one radius, and without the movable items."""
    still = bool(env.moves) and not env.changes
    return env.visitable is not None and env.visitable_radius in (None, env.radius) and not still


def _keep_promise(env: Env, visitable: np.ndarray, source: str) -> None:
    if not _promise_applies(env):
        return
    count = int(visitable.sum())
    if count != env.visitable:
        raise SceneError(f"{source}: promises visitable: {env.visitable} cells and has {count}. "
                         "Mend the scene, or ask for no promise: env.visitable=null")
    if env.visitable_sha256 is not None and fingerprint(visitable) != env.visitable_sha256:
        raise SceneError(f"{source}: its visitable cells are not those of visitable_sha256; "
                         f"theirs is {fingerprint(visitable)}.")
