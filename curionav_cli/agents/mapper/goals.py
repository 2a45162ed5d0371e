"""Where to go next: cells of the robot's own map that are worth landing on.

frontier and information follow Yamauchi, "A frontier-based approach for autonomous exploration" (1997): a frontier is
known free space beside unknown space.
"""

from __future__ import annotations

import cv2
import numpy as np

from curionav_cli.agents.mapper.memory import Memory
from curionav_cli.robot.planner import plan

LENGTH = 0.5  # metres; a shorter frontier is a gap between two rays
SIGHT = 2.0  # metres around a frontier that are expected to be seen from there


def unvisited(memory: Memory, x: float, y: float) -> np.ndarray:
    """Every cell that was never landed on; the search takes the nearest."""
    return ~memory.visited


def frontier(memory: Memory, x: float, y: float) -> np.ndarray:
    """Every frontier of at least half a metre; the search takes the nearest."""
    label, sizes = frontiers(memory)
    return (sizes * memory.cell >= LENGTH)[label]


def information(memory: Memory, x: float, y: float) -> np.ndarray:
    """The frontier with the most unknown area around its middle for each metre of the way there."""
    label, sizes = frontiers(memory)
    chosen = np.flatnonzero(sizes * memory.cell >= LENGTH)
    if not len(chosen):
        return np.zeros(label.shape, bool)
    unknown = cv2.boxFilter((~memory.map.known).astype(np.float32), -1, (2 * round(SIGHT / memory.cell) + 1,) * 2,
                            normalize=False, borderType=cv2.BORDER_CONSTANT)
    cost = plan(memory.map, x, y, (x, y))
    worth = [score(np.argwhere(label == one), unknown, memory, cost) for one in chosen]
    return label == chosen[int(np.argmax(worth))]


def score(cells: np.ndarray, unknown: np.ndarray, memory: Memory, cost) -> float:
    """Unknown cells around the middle one of a frontier's cells (n, 2), for each metre of the way to it."""
    row, column = cells[len(cells) // 2]
    x, y = memory.map.corner[0] + (column + 0.5) * memory.cell, memory.map.corner[1] + (row + 0.5) * memory.cell
    return float(unknown[row, column] / (cost.at(x, y) + 1.0))


def frontiers(memory: Memory) -> tuple[np.ndarray, np.ndarray]:
    """label (rows, columns) of connected frontier cells, 0 for none, and how many cells each label has (0 for 0)."""
    known = memory.map.known
    beside = cv2.dilate((~known).astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    edge = known & memory.free & ~memory.map.occupied & beside & ~memory.visited
    _, label, stats, _ = cv2.connectedComponentsWithStats(edge.astype(np.uint8), connectivity=8)
    sizes = stats[:, cv2.CC_STAT_AREA].copy()
    sizes[0] = 0
    return label, sizes


GOALS = {"unvisited": unvisited, "frontier": frontier, "information": information}
