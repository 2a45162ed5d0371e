"""A wave of the search over poses (lattice.py), by numpy."""

from __future__ import annotations

import numpy as np

from curionav_cli.constants import FORWARD, HEADINGS, LEFT, RIGHT
from curionav_cli.world.motion import free_share, moved

FEW = 8  # moves; one by one they take less time than all at once
Found = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def wave(pose: np.ndarray, place: np.ndarray, free: np.ndarray, seen: np.ndarray, cell: float, dx: np.ndarray,
         dy: np.ndarray) -> Found:
    """All new poses one action further than some (n, 3), columns x, y, heading; notes them in `seen`.

    place: (n,) those of the poses, no two alike; free: (rows, columns) bool; seen: (rows * columns * HEADINGS,) bool,
    by `places`; dx, dy: (HEADINGS,) metres of a move.
    Returns poses (m, 3), their places (m,), the actions that led there (m,) and the rows they came from (m,): moves
    ahead first, then turns to the left, then to the right; of poses that share a place the first stays.
    """
    parts = [_ahead(pose, free, seen, cell, dx, dy), _turned(pose, place, seen, 1), _turned(pose, place, seen, -1)]
    action = np.repeat([FORWARD, LEFT, RIGHT], [len(found) for found, _, _ in parts])
    found, places, parent = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return found, places, action, parent


def places(pose: np.ndarray, shape: tuple[int, ...], cell: float) -> np.ndarray:
    """One number for the cell and heading of each pose; poses outside are clipped to the border."""
    rows, columns = shape
    row = np.clip(np.floor(pose[:, 1] / cell).astype(np.int64), 0, rows - 1)
    column = np.clip(np.floor(pose[:, 0] / cell).astype(np.int64), 0, columns - 1)
    return (row * columns + column) * HEADINGS + pose[:, 2].astype(np.int64)


def _ahead(pose: np.ndarray, free: np.ndarray, seen: np.ndarray, cell: float, dx: np.ndarray,
           dy: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The new poses, places and parents of moves; looks closely only at those that lead to a free place."""
    x, y, heading = pose[:, 0], pose[:, 1], pose[:, 2].astype(np.int64)
    ahead = np.stack([x + dx[heading], y + dy[heading], heading], 1)
    place = places(ahead, free.shape, cell)
    clear = np.flatnonzero(~seen[place] & free.flat[place // HEADINGS])
    towards = heading[clear]
    clear = clear[_clear(free, cell, x[clear], y[clear], dx[towards], dy[towards])]
    _, first = np.unique(place[clear], return_index=True)
    clear = clear[np.sort(first)]
    seen[place[clear]] = True
    return ahead[clear], place[clear], clear


def _clear(free: np.ndarray, cell: float, x: np.ndarray, y: np.ndarray, dx: np.ndarray, dy: np.ndarray) -> np.ndarray:
    """(n,) bool: do straight moves from (x, y) by (dx, dy), metres, pass through free cells only?"""
    if len(x) > FEW:
        return free_share(free, cell, x, y, dx, dy) == 1.0
    moves = zip(x.tolist(), y.tolist(), dx.tolist(), dy.tolist(), strict=True)
    return np.array([not moved(free, cell, *move)[2] for move in moves], bool)


def _turned(pose: np.ndarray, place: np.ndarray, seen: np.ndarray,
            by: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The new poses, places and parents of turns: no two turns to one side share a place, as no two poses do."""
    heading = pose[:, 2].astype(np.int64)
    turned = (heading + by) % HEADINGS
    there = place - heading + turned
    new = np.flatnonzero(~seen[there])
    seen[there[new]] = True
    return np.stack([pose[new, 0], pose[new, 1], turned[new]], 1), there[new], new
