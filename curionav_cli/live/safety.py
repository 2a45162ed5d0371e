"""When the robot must stop: a fault of the connection, of a sensor or of the odometry."""

from __future__ import annotations

import math

from curionav_cli.records import Pose


class Fault(Exception):
    """Something because of which the robot is stopped and the episode ends; the message is one line."""


class Displaced(Fault):
    """A fault after which the robot's place is not known, so that a person must put it back."""


class MessageFault(Fault):
    """A message that cannot be used: another encoding or type than the profile says."""


class Geofence:
    """A circle around the dock that forward moves may not leave. centre: metres; radius: metres."""

    def __init__(self, centre: Pose, radius: float):
        self.centre, self.radius = centre, radius

    def forbids(self, pose: Pose, distance: float) -> bool:
        """Whether a move of `distance` metres ahead ends outside, and farther out than it began."""
        ahead = Pose(pose.x + distance * math.cos(pose.yaw), pose.y + distance * math.sin(pose.yaw), pose.yaw)
        return self._away(ahead) > max(self.radius, self._away(pose))

    def _away(self, pose: Pose) -> float:
        return math.hypot(pose.x - self.centre.x, pose.y - self.centre.y)
