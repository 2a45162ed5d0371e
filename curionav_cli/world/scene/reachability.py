"""The cells that a robot's centre can reach, as a mask on the coverage grid; needs no rendering.

A cell is visitable when its centre is farther than the robot's radius from every solid box and from
the outside of the scene, and a path of 4-neighbours leads to it from the start. builder.py (_reach) asks for them, and
trims those of a scene with `tune` to the number that its file promises (`visitable`).
"""

from __future__ import annotations

import hashlib
from collections import deque

import cv2
import numpy as np
from scipy import ndimage

from curionav_cli.errors import SceneError
from curionav_cli.geometry import rectangle_distance

TOUCH = 1e-9  # metres; a centre exactly at the radius is not clear, whatever the rounding
NEIGHBOURS = ((0, 1), (1, 0), (0, -1), (-1, 0))

CELLS = 4_000_000  # a hundred metres square in cells of 5 cm


def grid_shape(size: tuple[float, float], cell: float) -> tuple[int, int]:
    """(rows, columns) of the cells that cover a scene. Raises SceneError for more than CELLS.

    ROS maps have a limit of their own, ros_map.MOST_CELLS.
    """
    if not 0 < size[0] / cell * (size[1] / cell) <= CELLS:
        raise SceneError(f"{size[0]:g} x {size[1]:g} m in cells of {cell:g} m are more than {CELLS} cells, or none.")
    return whole_cells(size, cell)


def whole_cells(size: tuple[float, float], cell: float) -> tuple[int, int]:
    """(rows, columns) of the cells that cover a scene, without a limit."""
    return max(1, round(size[1] / cell)), max(1, round(size[0] / cell))


def clear_cells(low: np.ndarray, high: np.ndarray, size: tuple[float, float], cell: float,
                radius: float) -> np.ndarray:
    """(rows, columns) bool: centres farther than radius from the boxes low, high (K, 2) and the outside."""
    rows, columns = whole_cells(size, cell)
    x, y = (np.arange(columns) + 0.5) * cell, (np.arange(rows) + 0.5) * cell
    border = np.minimum(np.minimum(x, size[0] - x)[None, :], np.minimum(y, size[1] - y)[:, None])
    clear = border > radius + TOUCH
    first = np.floor((low - radius) / cell).astype(int) - 1
    last = np.ceil((high + radius) / cell).astype(int) + 1
    for box in range(len(low)):
        c, r = (slice(max(first[box, axis], 0), max(last[box, axis], 0)) for axis in (0, 1))
        near = rectangle_distance(x[c][None, :], y[r][:, None], low[box], high[box])
        clear[r, c] &= near > radius + TOUCH
    return clear


def covered_cells(low: np.ndarray, high: np.ndarray, shape: tuple[int, int], cell: float) -> np.ndarray:
    """(rows, columns) bool: cells whose centre lies inside a box."""
    covered = np.zeros(shape, bool)
    first = np.ceil(low / cell - 0.5 - TOUCH).astype(int).clip(0)
    last = np.floor(high / cell - 0.5 + TOUCH).astype(int).clip(-1) + 1
    for (c0, r0), (c1, r1) in zip(first, last, strict=True):
        covered[r0:r1, c0:c1] = True
    return covered


def component(clear: np.ndarray, row: int, column: int) -> np.ndarray:
    """The cells reached by 4-neighbour steps from (row, column); none where that cell is not clear."""
    label, _ = ndimage.label(clear)
    return (label == label[row, column]) & clear & clear[row, column]


def clearance(clear: np.ndarray) -> np.ndarray:
    """(rows, columns) float32: distance, in cells, to the nearest centre outside the mask or the grid."""
    padded = np.pad(clear, 1).view(np.uint8)
    return cv2.distanceTransform(padded, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]


def largest_component(clear: np.ndarray) -> np.ndarray:
    """The largest set of cells connected by 4-neighbour steps, as a mask."""
    label, count = ndimage.label(clear)
    sizes = np.bincount(label.ravel(), minlength=count + 1)
    sizes[0] = 0
    return (label == sizes.argmax()) & clear


def roomiest(clear: np.ndarray) -> tuple[int, int]:
    """The cell of this mask that is farthest from its complement; ties go to the lowest row, then column."""
    row, column = np.unravel_index(int(np.argmax(clearance(clear))), clear.shape)
    return int(row), int(column)


def trimmed(visitable: np.ndarray, start: tuple[int, int], target: int) -> np.ndarray:
    """The mask cut down to `target` cells by a fixed rule.

    Drops, again and again, the boundary cell that is farthest from the start (by steps between
    neighbours) and whose removal keeps its own neighbourhood connected; ties go to the lowest row,
    then column.
    """
    mask = visitable.copy()
    far = steps_from(mask, start)
    rows, columns = np.nonzero(mask)
    order = np.lexsort((columns, rows, -far[rows, columns]))
    candidates = list(zip(rows[order].tolist(), columns[order].tolist(), strict=True))
    left = int(mask.sum()) - target
    while left > 0:
        chosen = next(cell for cell in candidates if cell != start and _spare(mask, *cell))
        mask[chosen] = False
        candidates.remove(chosen)
        left -= 1
    return mask


def steps_from(mask: np.ndarray, start: tuple[int, int]) -> np.ndarray:
    """Steps between 4-neighbours from the start to each cell of the mask; -1 elsewhere."""
    steps = np.full(mask.shape, -1, np.int64)
    steps[start] = 0
    queue = deque([start])
    while queue:
        row, column = queue.popleft()
        for dr, dc in NEIGHBOURS:
            r, c = row + dr, column + dc
            if 0 <= r < mask.shape[0] and 0 <= c < mask.shape[1] and mask[r, c] and steps[r, c] < 0:
                steps[r, c] = steps[row, column] + 1
                queue.append((r, c))
    return steps


def _spare(mask: np.ndarray, row: int, column: int) -> bool:
    """True for a boundary cell whose removal leaves its neighbours connected."""
    ring = np.pad(mask, 1)[row:row + 3, column:column + 3].copy()
    ring[1, 1] = False
    sides = [(0, 1), (1, 0), (1, 2), (2, 1)]
    kept = [side for side in sides if ring[side]]
    if len(kept) == 4 or not kept:
        return False
    label, _ = ndimage.label(ring)
    return len({label[side] for side in kept}) == 1


def fingerprint(visitable: np.ndarray) -> str:
    """SHA-256 of the mask: of its shape and its packed bits."""
    return hashlib.sha256(repr(visitable.shape).encode() + np.packbits(visitable).tobytes()).hexdigest()
