"""The x-y half of the renderer: which boxes each image column meets, and which one each pixel sees.

B frames, C columns each (N = B * C in all), R rows, P pairs (column, box) worth evaluating.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from curionav_cli.world.boxes import EAST, NORTH, SOUTH, WEST
from curionav_cli.world.pattern import SIZE
from curionav_cli.world.surfaces import HAZE, Surfaces
from curionav_cli.world.texture import LEVEL_OFFSET, LEVELS

RANK = np.uint32(255)  # the low bits of a packed depth: rank of the pair in its column; 255: the plane
MISS = np.uint32(1 << 31)  # set in a packed depth: farther than everything
TINY = 1e-9


class Pairs(NamedTuple):
    """P pairs sorted by column, and one more for floor and ceiling at the end."""

    column: np.ndarray  # (P,)
    first: np.ndarray  # (N,) where each column's pairs begin
    rank: np.ndarray  # (P,) uint32
    box: np.ndarray  # (P + 1,)
    entry: np.ndarray  # (P + 1,) float32, depth at which the ray enters the box's ground plan
    leave: np.ndarray  # (P,) float32
    face: np.ndarray  # (P + 1,) the face it enters by
    along: np.ndarray  # (P + 1,) float32, where on that face: x or y
    grazing: np.ndarray  # (P + 1,) float32, pixels' stretch along that face


def nonzero(slope: np.ndarray) -> np.ndarray:
    """Directions without exact zeros, so that they can be divided by."""
    return np.where(np.abs(slope) < TINY, TINY, slope)


def find_pairs(surfaces: Surfaces, among: np.ndarray, x: np.ndarray, y: np.ndarray, dx: np.ndarray,
               dy: np.ndarray, reach: float) -> Pairs:
    """among (B or 1, K): boxes to try, FAR_BOX last; x, y (B,); dx, dy (B, C) float64."""
    frames, boxes, columns = len(x), among.shape[1], dx.shape[1]
    in_x, out_x = _slab(surfaces.low[among, 0] - x[:, None], surfaces.high[among, 0] - x[:, None], dx)
    in_y, out_y = _slab(surfaces.low[among, 1] - y[:, None], surfaces.high[among, 1] - y[:, None], dy)
    entry, leave = np.maximum(in_x, in_y), np.minimum(out_x, out_y)  # (B, K, C)
    np.maximum(entry, 0.0, out=entry)  # a box behind the camera is left before it is entered
    entry[:, -1], leave[:, -1] = reach, np.inf
    key = entry.view(np.uint32) | ((entry >= leave).astype(np.uint32) << 31)
    wall = np.minimum.reduce(key | surfaces.open[among][:, :, None], axis=1)
    chosen = (key <= wall[:, None]).transpose(0, 2, 1).copy()
    column, k = np.divmod(np.flatnonzero(chosen), boxes)
    frame, c = column // columns, column % columns
    at = (frame * boxes + k) * columns + c
    first = np.searchsorted(column, np.arange(frames * columns))
    rank = np.minimum(np.arange(len(column)) - first.take(column), int(RANK) - 1).astype(np.uint32)
    box = among[frame if len(among) > 1 else 0, k]
    met, left, by_x = entry.take(at), leave.take(at), in_x.take(at) >= in_y.take(at)
    right, up = dx.ravel().take(column), dy.ravel().take(column)
    face = np.where(by_x, np.where(right > 0, WEST, EAST), np.where(up > 0, SOUTH, NORTH))
    along = np.where(by_x, y.take(frame) + met * up, x.take(frame) + met * right)
    grazing = 1.0 / np.abs(np.where(by_x, right, up))
    plane = len(surfaces.low) - 1
    return Pairs(column, first, rank, _and(box, plane), _and(met, 0.0), left, _and(face, 0), _and(along, 0.0),
                 _and(grazing, 1.0))


def _and(values: np.ndarray, last: float) -> np.ndarray:
    longer = np.empty(len(values) + 1, values.dtype)
    longer[:-1], longer[-1] = values, last
    return longer


def _slab(low: np.ndarray, high: np.ndarray, direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Depths (B, K, C) float32 at which the rays enter and leave an interval, both relative to the camera."""
    rate = (1.0 / direction).astype(np.float32)[:, None]
    one, other = low.astype(np.float32)[:, :, None] * rate, high.astype(np.float32)[:, :, None] * rate
    return np.minimum(one, other), np.maximum(one, other)


def nearest(surfaces: Surfaces, pairs: Pairs, plane: np.ndarray) -> np.ndarray:
    """The pair that each pixel sees: (N, R) int, its last index for floor and ceiling.

    plane (R,) uint32: packed depth of floor and ceiling.
    """
    box = pairs.box[:-1]
    flat = (pairs.entry[:-1].view(np.uint32) & ~RANK) | pairs.rank
    shut = surfaces.open.take(box) == 0  # a closed wall is met by every row
    walls = np.minimum.reduceat(np.where(shut, flat, MISS), pairs.first)
    best = np.minimum(walls[:, None], plane)
    part = np.flatnonzero(~shut)
    if len(part):
        _over(best, _rows(surfaces, pairs, part), part, pairs)
    rank = best & RANK
    return np.where(rank == RANK, len(box), pairs.first[:, None] + rank)


def _rows(surfaces: Surfaces, pairs: Pairs, part: np.ndarray) -> np.ndarray:
    """(P, R) uint32: packed depth at which each row meets the box of a pair, MISS where it does not."""
    box = pairs.box.take(part)
    enter = np.maximum(surfaces.near.take(box, axis=0), pairs.entry.take(part)[:, None])
    leave = np.minimum(surfaces.far.take(box, axis=0), pairs.leave.take(part)[:, None])
    key = enter.view(np.uint32)
    missed = (enter >= leave).astype(np.uint32) << 31
    return ((key & ~RANK) | pairs.rank.take(part)[:, None]) | missed


def _over(best: np.ndarray, key: np.ndarray, part: np.ndarray, pairs: Pairs) -> None:
    """best (N, R) becomes the minimum of itself and the rows of its column's pairs."""
    column = pairs.column.take(part)
    turn = np.arange(len(part)) - np.searchsorted(column, column)
    for layer in range(int(turn.max()) + 1):
        here = np.flatnonzero(turn == layer)
        there = column.take(here)
        best[there] = np.minimum(best.take(there, axis=0), key.take(here, axis=0))


def wall_texels(surfaces: Surfaces, pairs: Pairs, camera: float,
                pixel: float) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """For each pair: texel row at the camera's height, texel rows a unit of slope, address, light."""
    side = pairs.box * 4 + pairs.face
    run, up = surfaces.side_along.take(side), surfaces.side_up.take(side)
    wide = pairs.entry * np.float32(pixel)
    area = wide * wide * (np.abs(run) * up * pairs.grazing).astype(np.float32) * np.float32(2.0)
    level = np.clip((np.maximum(area, 1.0).astype(np.float32).view(np.int32) >> 23) - 127 >> 1, 0, LEVELS - 1)
    column = (pairs.along * run + surfaces.side_shift.take(side)).astype(np.int64) & (SIZE - 1)
    address = surfaces.side_base.take(side) + LEVEL_OFFSET.take(level) + (column >> level) * SIZE
    address = np.where(pairs.box == len(surfaces.low) - 3, surfaces.side_base.take(side), address)
    light = surfaces.side_light.take(side) / (np.float32(1.0) + np.float32(HAZE) * pairs.entry)
    foot = np.float32(camera) * up + surfaces.side_foot.take(side)
    return foot, pairs.entry * up, address, light
