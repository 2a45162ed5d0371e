"""The waves of a search over poses (lattice.py), compiled by numba (the extra `fast`).

The same poses, in the same order, to the bit: each number is computed by the same operations in the same order, and
nothing is fused or reordered (no fastmath).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from curionav_cli.agents.lattice_numpy import Found
from curionav_cli.constants import FORWARD, HEADINGS, LEFT, RIGHT

compiled = njit(cache=True, nogil=True, error_model="numpy")


@compiled
def place_of(x, y, heading, cell, rows, columns):
    """lattice_numpy.places of one pose."""
    row = min(max(math.floor(y / cell), 0), rows - 1)
    column = min(max(math.floor(x / cell), 0), columns - 1)
    return (row * columns + column) * HEADINGS + heading


@compiled
def crossing(position, move, line):
    """When (in moves) the next grid line but `line` is crossed, positions in cells (motion.free_share)."""
    if move > 0:
        return max((math.floor(position) + 1 + line - position) * (1.0 / move), 0.0)
    if move < 0:
        return max((math.floor(position) - line - position) * (1.0 / move), 0.0)
    return math.inf


@compiled
def is_free(free, y, x):
    """Is the cell at (x, y), in cells, inside and free?"""
    row, column = math.floor(y), math.floor(x)
    return 0 <= row < free.shape[0] and 0 <= column < free.shape[1] and free[row, column]


@compiled
def is_clear(free, cell, x, y, dx, dy):
    """Does a straight move by (dx, dy), metres, pass through free cells only? As motion.free_share == 1."""
    px, py, qx, qy = x / cell, y / cell, dx / cell, dy / cell
    if not is_free(free, (y + dy) / cell, (x + dx) / cell) or not is_free(free, py + qy, px + qx):
        return False
    before, over_x, over_y = 0.0, 0, 0
    next_x, next_y = crossing(px, qx, 0), crossing(py, qy, 0)
    while before < 1.0:
        after = min(next_x, next_y, 1.0)
        middle = 0.5 * (after + before)
        if not is_free(free, py + middle * qy, px + middle * qx):
            return False
        if after == next_x:
            over_x += 1
            next_x = crossing(px, qx, over_x)
        elif after == next_y:
            over_y += 1
            next_y = crossing(py, qy, over_y)
        before = after
    return True


@compiled
def wave(pose, place, free, seen, cell, dx, dy):
    """All new poses one action further, in the order of lattice_numpy.Waves."""
    rows, columns = free.shape
    found, places = np.empty((3 * len(pose), 3)), np.empty(3 * len(pose), np.int64)
    action, parent = np.empty(3 * len(pose), np.int64), np.empty(3 * len(pose), np.int64)
    count = 0
    for kind in (FORWARD, LEFT, RIGHT):
        for i in range(len(pose)):
            x, y, heading = pose[i, 0], pose[i, 1], int(pose[i, 2])
            if kind == FORWARD:
                x, y = x + dx[heading], y + dy[heading]
                at = place_of(x, y, heading, cell, rows, columns)
            else:
                turned = (heading + (1 if kind == LEFT else HEADINGS - 1)) % HEADINGS
                at, heading = place[i] - heading + turned, turned
            if seen[at] or (kind == FORWARD and not is_clear(free, cell, pose[i, 0], pose[i, 1], dx[heading],
                                                             dy[heading])):
                continue
            seen[at] = True
            found[count, 0], found[count, 1], found[count, 2] = x, y, heading
            places[count], action[count], parent[count] = at, kind, i
            count += 1
    return found[:count], places[:count], action[:count], parent[:count]


class Waves:
    """What a search calls for each wave; arguments and results as of lattice_numpy.Waves."""

    def __init__(self, *held: np.ndarray | float):
        self.held = held

    def __call__(self, pose: np.ndarray, place: np.ndarray) -> Found:
        return wave(pose, place, *self.held)
