"""Scan-to-map matching: a scan is aligned with the walls in earlier scans of the episode.

The plane is cut into squares; each keeps the mean and the spread of the returns in it (the normal distributions
transform of Biber and Strasser 2003). Where they lie along a line, that is a piece of wall, and a match minimises the
distance of new returns to it. A square with enough returns does not change any more, so that the walls near the dock,
mapped early and with little drift, keep their place. There are four layers, by the quadrant that the ray points to, so
that the two sides of a thin wall are kept apart. Nothing here uses the true world.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.measurements import Scan

SIDE = 512  # squares; what is farther away than their whole width shares a square with what is near
SETTLED, FEWEST = 30, 4  # returns: a square with SETTLED takes no more; one with fewer than FEWEST is no wall
THIN, LONG = 0.3, 0.02  # a wall's spread across by that along, at most; and that along, metres, at least
ROUNDS, FIRST, STILL = 10, 2, 1e-4  # iterations, the first of them, and the step (metres, radians) that ends them
WIDE, NARROW = 0.3, 0.08  # metres from its wall beyond which a return is ignored, in the first rounds and the last
ENOUGH, SHARE = 25, 0.5  # the least returns on walls, and their least share among those in wall squares
FEW, VAGUE = 20.0, 1e-3  # information that is subtracted as if no return had given it, and what is left at least
BASIN = 0.5, math.radians(12.0)  # metres and radians: a match farther from the guess is none


class Match(NamedTuple):
    """A matched pose, its information (3, 3) for returns of unit variance, and the share of returns on walls among
    those in wall squares."""

    pose: Pose
    information: np.ndarray
    share: float

    @property
    def fits(self) -> bool:
        """True when enough of the returns lie on walls."""
        return self.share >= SHARE

    def variance(self, noise: float) -> np.ndarray:
        """The covariance (3, 3) of the pose, with returns off their walls by `noise` metres (sd).

        A direction that few walls constrain counts as unconstrained: those few may be wrong associations.
        """
        information, axes = np.linalg.eigh(self.information)
        return (axes * (noise**2 / np.maximum(information - FEW, VAGUE))) @ axes.T


class NdtMap:
    """The map of normal distributions. cell: width of a square, metres. SAVED: the names of its arrays.

    sums (S, 6): number of returns, and sums of their x, y, xx, xy, yy within the square. known (S,): is it a wall?
    """

    SAVED = ("square", "sums", "walls", "known")

    def __init__(self, cell: float = 0.25):
        self.cell = cell
        self.sums = np.zeros((4 * SIDE * SIDE, 6))
        self.walls = np.zeros((4 * SIDE * SIDE, 4))  # a point (x, y) of the wall in the square, and its normal
        self.known = np.zeros(4 * SIDE * SIDE, bool)

    def insert(self, pose: Pose, scan: Scan) -> None:
        """Insert a scan taken at an estimated pose."""
        x, y = placed(pose, *points(scan))
        square, left, below = self._squares(x, y, x - pose[0], y - pose[1])
        free = self.sums[square, 0] < SETTLED
        square, x, y = square[free], (x - left)[free], (y - below)[free]
        np.add.at(self.sums, square, np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1))
        self._find_walls(square, left[free], below[free])

    def match(self, guess: Pose, scan: Scan) -> Match | None:
        """The pose near the guess where the scan fits best; None where too little of the map is known."""
        own_x, own_y = points(scan)
        pose = np.array(guess)
        for number in range(ROUNDS):
            lever_x, lever_y = placed(Pose(0.0, 0.0, pose[2]), own_x, own_y)
            x, y = lever_x + pose[0], lever_y + pose[1]
            square = self._squares(x, y, lever_x, lever_y)[0]
            there = np.flatnonzero(self.known[square])
            if len(there) < ENOUGH:
                return None
            wall = self.walls[square[there]]
            away = wall[:, 2] * (x[there] - wall[:, 0]) + wall[:, 3] * (y[there] - wall[:, 1])
            near = np.abs(away) < (WIDE if number < FIRST else NARROW)
            if near.sum() < ENOUGH:
                return Match(guess, np.zeros((3, 3)), 0.0)
            normal, at = wall[near, 2:], there[near]
            slope = np.column_stack([normal, normal[:, 1] * lever_x[at] - normal[:, 0] * lever_y[at]])
            information, share = slope.T @ slope, near.sum() / len(there)
            step = np.linalg.solve(information + STIFF, slope.T @ -away[near])
            pose = pose + step
            if np.abs(step).max() < STILL and number >= FIRST:
                break
        found = Pose(float(pose[0]), float(pose[1]), wrapped(float(pose[2])))
        far = math.hypot(found.x - guess.x, found.y - guess.y), abs(wrapped(found.yaw - guess.yaw))
        inside = far[0] < BASIN[0] and far[1] < BASIN[1]
        return Match(found, information, share if inside else 0.0)

    def search(self, guess: Pose, scan: Scan, ahead: Sequence[float], aside: Sequence[float] = (0.0,),
               turns: Sequence[float] = (0.0,)) -> Match | None:
        """The best of the matches begun from poses ahead of the guess, aside (m) and turned (rad)."""
        cosine, sine = math.cos(guess.yaw), math.sin(guess.yaw)
        starts = [Pose(guess.x + cosine * a - sine * b, guess.y + sine * a + cosine * b, guess.yaw + turn)
                  for a in ahead for b in aside for turn in turns]
        found = [match for start in starts if (match := self.match(start, scan))]
        return max(found, key=lambda match: match.fits * np.trace(match.information[:2, :2]), default=None)

    def save(self) -> dict[str, np.ndarray]:
        """The arrays that `load` restores: the squares that hold returns."""
        used = np.flatnonzero(self.sums[:, 0])
        return {"square": used, "sums": self.sums[used], "walls": self.walls[used], "known": self.known[used]}

    def load(self, arrays: dict[str, np.ndarray]) -> None:
        """Restore the arrays of `save` in an empty map."""
        used = arrays["square"]
        self.sums[used], self.walls[used], self.known[used] = arrays["sums"], arrays["walls"], arrays["known"]

    def _squares(self, x: np.ndarray, y: np.ndarray, ray_x: np.ndarray,
                 ray_y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The square of each point, in the layer of its ray, and its lower left corner."""
        column, row = np.floor(x / self.cell), np.floor(y / self.cell)
        layer = 2 * (ray_y > 0.0) + (ray_x > 0.0)
        square = (layer * SIDE + row.astype(np.int64) % SIDE) * SIDE + column.astype(np.int64) % SIDE
        return square, column * self.cell, row * self.cell

    def _find_walls(self, square: np.ndarray, left: np.ndarray, below: np.ndarray) -> None:
        """Fit lines to the returns in these squares."""
        count, x, y, xx, xy, yy = self.sums[square].T
        x, y = x / count, y / count
        xx, xy, yy = xx / count - x * x, xy / count - x * y, yy / count - y * y
        spread = np.hypot(0.5 * (xx - yy), xy)
        along, across = 0.5 * (xx + yy) + spread, np.maximum(0.5 * (xx + yy) - spread, 0.0)
        angle = 0.5 * np.arctan2(2.0 * xy, xx - yy)
        self.walls[square] = np.column_stack([left + x, below + y, -np.sin(angle), np.cos(angle)])
        self.known[square] = (count >= FEWEST) & (across < THIN**2 * along) & (along > LONG**2)


STIFF = np.diag([1.0, 1.0, 1.0])  # damping along directions without walls, as of one return


def points(scan: Scan) -> tuple[np.ndarray, np.ndarray]:
    """The returns as points, x ahead and y to the left, metres: (n,) each."""
    seen = np.isfinite(scan.range)
    reach, bearing = scan.range[seen], scan.bearing[seen]
    return reach * np.cos(bearing), reach * np.sin(bearing)


def placed(pose: Pose, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Transform points from the robot's frame at a pose into the frame of that pose: (n,) each, metres."""
    cosine, sine = math.cos(pose[2]), math.sin(pose[2])
    return pose[0] + cosine * x - sine * y, pose[1] + sine * x + cosine * y
