"""The geometry of a frame in numpy: the boxes that each image column meets, and the nearest one for each pixel.

B frames, C columns each (N = B * C in all), R rows, K boxes to try. A pair is a column and a box worth
painting: first the N nearest closed walls, one a column, then the P open boxes in front of them.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from curionav_cli.world.render.box_tables import BoxTables
from curionav_cli.world.render.culling import Candidates
from curionav_cli.world.scene.boxes import EAST, NORTH, SOUTH, WEST

TINY = 1e-9
MISS = np.uint32(1 << 31)  # as the bits of a depth: farther than everything
LOW_HALF = np.uint64(0xFFFFFFFF)


class Rays(NamedTuple):
    """Rays of B frames, (B, 2, C) each: along x and along y. Rays are scaled to one metre of depth."""

    run: np.ndarray  # float32
    rate: np.ndarray  # float32: 1 / run
    face: np.ndarray  # int64: of the two faces of a box across this axis, the one that the ray enters by


class Pairs(NamedTuple):
    """N + P pairs of a column and a box, the open ones in layers: each column's first, each column's second, and so on.

    A layer begins with the columns that have the most, so the next one is about the first so many of them.
    """

    walls: int  # N
    layers: np.ndarray  # where each layer but the first begins, counted from N
    column: np.ndarray  # int64
    box: np.ndarray  # int64
    entry: np.ndarray  # float32, depth at which the ray enters the box's ground plan
    leave: np.ndarray  # float32
    ray: np.ndarray  # int64, index into Rays: frame, axis across which it enters, column


def rays(cosine: np.ndarray, sine: np.ndarray, across: np.ndarray) -> Rays:
    """The rays of B cameras. cosine, sine (B,) of the yaw; across (C,): metres to the right per metre of depth."""
    run = np.stack([cosine[:, None] + across * sine[:, None], sine[:, None] - across * cosine[:, None]], axis=1)
    run = np.where(np.abs(run) < TINY, TINY, run)
    face = np.where(run > 0, [[WEST], [SOUTH]], [[EAST], [NORTH]])
    return Rays(run.astype(np.float32), (1.0 / run).astype(np.float32), face)


def find_pairs(candidates: Candidates, pose: np.ndarray, directions: Rays, reach: float) -> Pairs:
    """Find the pairs of B frames. pose (2, B) float64, metres; every column meets FAR_BOX at depth `reach`."""
    entry, leave, across_y, met = _intervals(candidates, pose, directions.rate)
    walls, (_, boxes, columns) = candidates.walls, entry.shape
    entry[:, walls - 1] = reach
    met[:, walls - 1] = entry[:, walls - 1].view(np.uint32)
    shut = met[:, :walls]
    ahead = (met[:, walls:] <= shut.min(axis=1)[:, None]).transpose(0, 2, 1).ravel().nonzero()[0]
    column, k = np.divmod(ahead, max(boxes - walls, 1))
    before = np.arange(len(entry) * columns)
    count = np.bincount(column, minlength=len(before))
    turn = np.arange(len(column)) - (np.cumsum(count) - count).take(column)
    order = np.argsort((boxes + 1) * turn - count.take(column), kind="stable")
    column = np.concatenate([before, column.take(order)])
    k = np.concatenate([shut.argmin(axis=1).ravel(), k.take(order) + walls])
    frame, across = column // columns, column % columns
    k_of_frame = frame * boxes + k
    at = k_of_frame * columns + across
    ray = (2 * frame + across_y.view(np.int8).take(at)) * columns + across
    box = candidates.boxes.take(k if len(candidates.boxes) == 1 else k_of_frame)
    layers = np.cumsum(np.bincount(turn))[:-1]
    return Pairs(len(before), layers, column, box, entry.take(at), leave.take(at), ray)


def _intervals(candidates: Candidates, pose: np.ndarray,
               rate: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(B, K, C): depth at which a ray enters and leaves a ground plan; across y? and MISS or the bits of entry."""
    corner = (candidates.bounds - pose[:, :, None]).astype(np.float32)[..., None]
    rate = rate.transpose(1, 0, 2)[:, :, None]
    one, other = corner[0] * rate, corner[1] * rate  # (2, B, K, C)
    into, out = np.minimum(one, other), np.maximum(one, other, out=one)
    entry, leave = np.maximum(into[0], into[1]), np.minimum(out[0], out[1])
    np.maximum(entry, 0.0, out=entry)  # a box behind the camera is left before it is entered
    return entry, leave, into[1] > into[0], _met(entry, leave)


def _met(entry: np.ndarray, leave: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
    """The bits of entry, uint32, with MISS set where it is not before leave. (np.where takes five times as long.)"""
    bits = (entry - leave).view(np.uint32)
    bits &= MISS
    bits ^= MISS
    return np.bitwise_or(bits, entry.view(np.uint32), out=bits if out is None else out)


def nearest(tables: BoxTables, pairs: Pairs, frames: int) -> np.ndarray:
    """The nearest surface of each pixel: (N, R) uint64, its depth (a float32's bits) over an index of 32 bits.

    An index below N + P is the side of that pair; then come P tops and undersides of the open pairs,
    then the rows of floor and ceiling, frame by frame.
    """
    columns, rows, open_pairs = pairs.walls, tables.near.shape[1], len(pairs.box) - pairs.walls
    plane = np.arange(frames * rows).reshape(frames, 1, rows) + len(pairs.box) + open_pairs
    plane = packed(tables.near[-1].view(np.uint32), plane)
    walls = packed(pairs.entry[:columns].view(np.uint32), np.arange(columns)).reshape(frames, -1, 1)
    best = np.minimum(walls, plane).reshape(columns, rows)
    if open_pairs:
        _over(best, _open_rows(tables, pairs), pairs)
    return best


def packed(depth: np.ndarray, index: np.ndarray) -> np.ndarray:
    """Pack into uint64 that sort by depth (uint32: positive floats sort like their bits), then by index."""
    both = np.empty((*index.shape, 2), "<u4")
    both[..., 0], both[..., 1] = index, depth
    return both.view("<u8")[..., 0]


def unpacked(best: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unpack (B, C, R) to (B, R, C): index, int64 and a new array, and depth, float32 and a view."""
    depth = best.view("<f4").reshape(*best.shape, 2)[..., 1]
    index = np.bitwise_and(best.transpose(0, 2, 1), LOW_HALF, order="C").view(np.int64)
    return index, depth.transpose(0, 2, 1)


def _open_rows(tables: BoxTables, pairs: Pairs) -> np.ndarray:
    """(P, R): where and as what each row meets the open box of a pair."""
    first = pairs.walls
    box, count = pairs.box[first:], len(pairs.box) - first
    entry, near = pairs.entry[first:, None], tables.near.take(box, axis=0)
    enter = np.maximum(near, entry)
    leave = np.minimum(tables.far.take(box, axis=0), pairs.leave[first:, None])
    both = np.empty((*near.shape, 2), "<u4")
    index = np.subtract(entry, near, out=near).view(np.uint32)
    index >>= 31  # 1 for a top, which is farther than the side
    index *= count
    np.add(index, np.arange(first, first + count, dtype=np.uint32)[:, None], out=both[..., 0])
    _met(enter, leave, out=both[..., 1])
    return both.view("<u8")[..., 0]


def _over(best: np.ndarray, key: np.ndarray, pairs: Pairs) -> None:
    """best (N, R) becomes the minimum of itself and the rows of its column's open pairs; key is used up."""
    ends = [0, *pairs.layers.tolist(), len(key)]
    for first, last in pairwise(ends[1:]):
        least = key[:last - first]
        np.minimum(least, key[first:last], out=least)
    there = pairs.column[pairs.walls:][:ends[1]]
    best[there] = np.minimum(best.take(there, axis=0), key[:ends[1]])
