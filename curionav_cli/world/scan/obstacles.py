"""What stands in a robot's way in a mesh: the edges of its triangles, cut to the heights of the robot, as points."""

from __future__ import annotations

import numpy as np

from curionav_cli.world.scan.mesh import Mesh

SPACING = 0.01  # metres between points: the nearest one is at most 0.2 mm farther than the edge, seen from 0.1 m
MANY = 1_000_000  # points, beyond which those of one square of MERGED metres become one
MERGED = 0.002
PART = 100_000  # triangles cut at once


def obstacle_points(mesh: Mesh, low: float, high: float) -> np.ndarray:
    """(n, 2) float64: points along the outlines, from above, of all that is between two heights, metres."""
    above, below = mesh.vertices[:, 2] > low, mesh.vertices[:, 2] < high
    which = np.flatnonzero(above[mesh.faces].any(axis=1) & below[mesh.faces].any(axis=1))
    points, many = np.zeros((0, 2)), False
    for at in range(0, len(which), PART):
        points = np.concatenate([points, _points(mesh.corners(which[at:at + PART]).astype(np.float64), low, high)])
        if len(points) > MANY:
            points, many = merged(points), True
    return merged(points) if many else points


def merged(points: np.ndarray) -> np.ndarray:
    """One of the points in each square of MERGED metres."""
    square = np.floor(points / MERGED).astype(np.int64)
    square -= square.min(axis=0)
    return points[np.unique(square[:, 0] * (square[:, 1].max() + 1) + square[:, 1], return_index=True)[1]]


def _points(corners: np.ndarray, low: float, high: float) -> np.ndarray:
    edges = [(corners[:, at], corners[:, (at + 1) % 3]) for at in range(3)]
    pieces = [cut(start, end, low, high) for start, end in edges]
    pieces += [across(edges, height) for height in (low, high)]
    return np.concatenate([along(start, end) for start, end in pieces])


def cut(start: np.ndarray, end: np.ndarray, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """The parts of edges (n, 3) between two heights, seen from above: starts and ends (m, 2)."""
    rise = end[:, 2] - start[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (low - start[:, 2]) / rise, (high - start[:, 2]) / rise
    inside = (start[:, 2] >= low) & (start[:, 2] <= high)
    first = np.where(rise == 0.0, np.where(inside, 0.0, 2.0), np.minimum(one, other)).clip(0.0)
    last = np.where(rise == 0.0, 1.0, np.maximum(one, other)).clip(None, 1.0)
    kept = first <= last
    run, begin = (end - start)[kept, :2], start[kept, :2]
    return begin + first[kept, None] * run, begin + last[kept, None] * run


def across(edges: list[tuple[np.ndarray, np.ndarray]], height: float) -> tuple[np.ndarray, np.ndarray]:
    """Where triangles are cut by a level plane, seen from above: starts and ends (m, 2)."""
    found, cuts = np.zeros((2, len(edges[0][0]), 2)), np.zeros(len(edges[0][0]), int)
    for start, end in edges:
        crosses = np.flatnonzero((start[:, 2] > height) != (end[:, 2] > height))
        share = (height - start[crosses, 2]) / (end[crosses, 2] - start[crosses, 2])
        found[cuts[crosses], crosses] = start[crosses, :2] + share[:, None] * (end - start)[crosses, :2]
        cuts[crosses] += 1
    return found[0, cuts == 2], found[1, cuts == 2]


def along(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(n, 2): points at most SPACING apart on straight lines, their ends included."""
    run = end - start
    steps = np.ceil(np.hypot(run[:, 0], run[:, 1]) / SPACING).astype(int).clip(1)
    line = np.repeat(np.arange(len(run)), steps + 1)
    number = np.arange(len(line)) - np.repeat(np.cumsum(steps + 1) - (steps + 1), steps + 1)
    return start[line] + (number / steps[line])[:, None] * run[line]
