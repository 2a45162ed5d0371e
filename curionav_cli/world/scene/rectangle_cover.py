"""Covering a map's solid cells with few rectangles."""

from __future__ import annotations

import cv2
import numpy as np


def cover(solid: np.ndarray, longest: int, hidden: bool = False) -> np.ndarray:
    """Rectangles (n, 4) int, row0 column0 row1 column1 (ends excluded), over a (rows, columns) mask.

    Every solid cell that touches a free one, corners included, is covered, with `hidden` every solid
    cell; no free cell is. Rectangles may overlap, and are at most `longest` cells long. Greedy from the lowest
    left cell: of the widest and the tallest rectangle, the one that covers more uncovered cells.
    """
    wanted = solid.copy() if hidden else solid & widened(~solid)
    right, up = runs(solid), runs(solid.T).T
    found: list[tuple[int, int, int, int]] = []
    for flat in np.flatnonzero(wanted):
        row, column = divmod(int(flat), solid.shape[1])
        if not wanted[row, column]:
            continue
        options = (_widest(right, row, column, longest), _widest(up.T, column, row, longest)[::-1])
        tall, wide = max(options, key=lambda size: np.count_nonzero(wanted[row:row + size[0], column:column + size[1]]))
        wanted[row:row + tall, column:column + wide] = False
        found.append((row, column, row + tall, column + wide))
    return np.array(found, np.int64).reshape(-1, 4)


def widened(mask: np.ndarray) -> np.ndarray:
    """The mask and all its neighbours, corners included."""
    return cv2.dilate(mask.view(np.uint8), np.ones((3, 3), np.uint8)).view(bool)


def runs(mask: np.ndarray) -> np.ndarray:
    """How many cells of the mask follow to the right of each cell without a break, itself included."""
    columns = np.arange(mask.shape[1], dtype=np.int32)
    stop = np.where(mask, np.int32(mask.shape[1]), columns)
    stop = np.minimum.accumulate(stop[:, ::-1], axis=1)[:, ::-1]
    return stop - columns


def _widest(right: np.ndarray, row: int, column: int, longest: int) -> tuple[int, int]:
    """(height, width) of the rectangle as wide as this cell's run, and as high as the runs above allow."""
    width = min(int(right[row, column]), longest)
    above = right[row:row + longest, column] >= width
    return (len(above) if above.all() else int(above.argmin())), width
