"""The way to the place with the highest rate: its worth for each action of the way there and of the stay.

The rate of a place of worth w that n actions lead to is w / (n + stay), as in Charnov's marginal value theorem (1976)
for patches. It falls with n, so that the search ends as soon as no place further away could have a higher one.
"""

from __future__ import annotations

from contextlib import closing

import cv2
import numpy as np

from curionav_cli.agents.lattice import Lattice, Links, trace


def best_way(lattice: Lattice, x: float, y: float, heading: int, worth: np.ndarray, stay: float) -> list[int]:
    """The actions to the cell of the highest rate from a pose on the grid; [] where no worth can be reached.

    worth: (rows, columns) float32, zero or more; lattice.goal is not looked at.
    """
    most, best, chosen = float(worth.max(initial=0.0)), 0.0, (0, 0)
    links: Links = []
    with closing(lattice.spread(x, y, heading, links)) as waves:
        for cell in waves:
            value = worth.flat[cell]
            if value.max(initial=0.0) / (len(links) + stay) > best:
                best, chosen = float(value.max()) / (len(links) + stay), (len(links), int(value.argmax()))
            if most / (len(links) + 1 + stay) <= best:
                break
    return trace(links[:chosen[0]], chosen[1]) if best else []


def within_reach(free: np.ndarray, known: np.ndarray, row: int, column: int, near: int) -> np.ndarray:
    """(rows, columns) bool: free cells, known or beside known ones, that hang together with (row, column).

    near: cells around the robot, which its camera does not see; they count as known.
    """
    seen = cv2.dilate(known.astype(np.uint8), np.ones((3, 3), np.uint8))
    seen[max(0, row - near):row + near + 1, max(0, column - near):column + near + 1] = 1
    seen[~free] = 0
    seen[row, column] = 1
    _, label = cv2.connectedComponents(seen, connectivity=8)
    return label == label[row, column]
