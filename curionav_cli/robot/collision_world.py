"""The obstacles of one episode as rectangles: collisions of the true robot, and ranges of its sensors.

Everything that reaches below the robot's height is an obstacle, for LiDAR and depth camera too; so are the cells of a
ROS map that are no floor. Only the simulated robot and its sensors import this module.
"""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.geometry import ray_ranges, rectangle_distance
from curionav_cli.world.scene.rectangle_cover import cover
from curionav_cli.world.scene.scene import Scene

MARGIN = 1e-3  # metres; a body that meets something stops this much before it
MOVED = 0.5  # metres; a list of near rectangles is used until the point has moved so far


Rectangle = tuple[tuple[float, float], tuple[float, float]]


class CollisionWorld:
    """Rectangles low, high (K, 2), metres. station: the dock's body, which a scene does not list."""

    def __init__(self, scene: Scene, station: Rectangle | None = None):
        solid = scene.boxes.solid(scene.agent_height)
        outside = cover(~scene.plan.floor, longest=40) * scene.plan.cell
        self.low = np.concatenate([scene.boxes.low[solid, :2], outside[:, 1::-1]])
        self.high = np.concatenate([scene.boxes.high[solid, :2], outside[:, :1:-1]])
        if station:
            self.low, self.high = np.vstack([self.low, station[0]]), np.vstack([self.high, station[1]])
        self._near: dict[float, tuple[float, float, np.ndarray, np.ndarray]] = {}
        self._room = (0.0, 0.0, 0.0)  # where clearance was last measured, and how much there was

    def near(self, x: float, y: float, reach: float) -> tuple[np.ndarray, np.ndarray]:
        """The rectangles that may be within `reach` metres of a point: low, high (k, 2)."""
        at_x, at_y, low, high = self._near.get(reach, (math.inf, math.inf, self.low, self.high))
        if math.hypot(x - at_x, y - at_y) > MOVED:
            close = rectangle_distance(x, y, self.low.T, self.high.T) <= reach + MOVED
            low, high = self.low[close], self.high[close]
            self._near[reach] = (x, y, low, high)
        return low, high

    def clearance(self, x: float, y: float, reach: float = 1.0) -> float:
        """Metres from a point to the nearest obstacle, at most `reach`."""
        low, high = self.near(x, y, reach)
        return min(reach, float(rectangle_distance(x, y, low.T, high.T).min(initial=reach)))

    def has_room(self, x: float, y: float, distance: float) -> bool:
        """True when no obstacle is within `distance` metres of a point. Cheap in open space."""
        at_x, at_y, room = self._room
        if math.hypot(x - at_x, y - at_y) + distance < room:
            return True
        self._room = (x, y, self.clearance(x, y))
        return distance < self._room[2]

    def travel(self, x: float, y: float, dx: float, dy: float, radius: float) -> float:
        """Metres that a disc can move along (dx, dy) before it touches an obstacle."""
        length = math.hypot(dx, dy)
        if length == 0.0 or self.has_room(x, y, length + radius):
            return length
        low, high = self.near(x, y, 1.0)
        ux, uy = dx / length, dy / length
        nearest = np.clip((x, y), low, high) - (x, y)  # from the point to each rectangle
        overlapping = np.hypot(nearest[:, 0], nearest[:, 1]) < radius
        if (nearest[overlapping] @ (ux, uy) > 0.0).any():
            return 0.0
        reach = disc_range(x, y, ux, uy, radius, low[~overlapping], high[~overlapping])
        return length if reach >= length else max(0.0, reach - MARGIN)

    def touching(self, x: float, y: float, radius: float) -> float | None:
        """The direction, in radians, of the obstacle that a disc touches, or None."""
        low, high = self.near(x, y, 1.0)
        nearest = np.clip((x, y), low, high) - (x, y)
        apart = np.hypot(nearest[:, 0], nearest[:, 1])
        if not len(apart) or apart.min() > radius + 2.0 * MARGIN:
            return None
        dx, dy = nearest[apart.argmin()]
        return math.atan2(dy, dx)

    def ranges(self, x: float, y: float, cosine: np.ndarray, sine: np.ndarray, far: float) -> np.ndarray:
        """Ranges (A,) of rays from a point, metres; inf where they meet nothing within `far` metres."""
        found = ray_ranges(x, y, cosine, sine, *self.near(x, y, far))
        found[found > far] = np.inf
        return found


def disc_range(x: float, y: float, ux: float, uy: float, radius: float, low: np.ndarray, high: np.ndarray) -> float:
    """Metres that a disc, touching nothing yet, moves along the unit vector (ux, uy) to the first rectangle, or inf."""
    wide, tall = np.array([radius, 0.0]), np.array([0.0, radius])
    sides = ray_ranges(x, y, np.array([ux]), np.array([uy]), np.concatenate([low - wide, low - tall]),
                       np.concatenate([high + wide, high + tall]))
    corner_x = np.concatenate([low[:, 0], low[:, 0], high[:, 0], high[:, 0]]) - x
    corner_y = np.concatenate([low[:, 1], high[:, 1], low[:, 1], high[:, 1]]) - y
    along, across = corner_x * ux + corner_y * uy, corner_x * uy - corner_y * ux
    meets = (np.abs(across) < radius) & (along > 0.0)
    corners = along[meets] - np.sqrt(radius**2 - across[meets] ** 2)
    return float(min(sides[0], corners.min(initial=math.inf)))
