"""The way to the place with the highest rate: its worth for each action of the way there and of the stay.

The rate of a place of worth w that n actions lead to is w / (n + stay), as in Charnov's marginal value theorem (1976)
for patches. It falls with n, so that the search ends as soon as no place further away could have a higher one.
"""

from __future__ import annotations

import cv2
import numpy as np

from curionav_cli.agents.lattice import Lattice, trace
from curionav_cli.constants import HEADINGS


def best_way(lattice: Lattice, x: float, y: float, heading: int, worth: np.ndarray, stay: float) -> list[int]:
    """The actions to the cell of the highest rate from a pose on the grid; [] where no worth can be reached.

    worth: (rows, columns) float32, zero or more; lattice.goal is not looked at.
    """
    most = float(worth.max(initial=0.0))
    pose, seen = np.array([[x, y, heading]]), np.zeros(lattice.free.size * HEADINGS, bool)
    waves: list[tuple[np.ndarray, np.ndarray]] = []
    best, chosen = 0.0, (0, 0)
    while len(pose) and most / (len(waves) + 1 + stay) > best:
        pose, action, parent = lattice.grow(pose, seen)
        place = lattice.places(pose)
        fresh = np.flatnonzero(~seen[place])
        _, first = np.unique(place[fresh], return_index=True)
        first = fresh[np.sort(first)]
        seen[place[first]] = True
        waves.append((action[first], parent[first]))
        pose, value = pose[first], worth.flat[place[first] // HEADINGS]
        if value.max(initial=0.0) / (len(waves) + stay) > best:
            best, chosen = float(value.max()) / (len(waves) + stay), (len(waves), int(value.argmax()))
    return trace(waves[:chosen[0]], chosen[1]) if best else []


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
