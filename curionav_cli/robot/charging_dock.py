"""The charging dock: its true pose, contact with the robot, and when current flows.

The docked robot's centre is at the scene's `dock`; the station lies behind that, and `yaw` points from it into the
room. In the dock's frame x leads away from the station along its axis and the docked robot stands at the origin with
its front to the station.
"""

from __future__ import annotations

import math

from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.docking_settings import Contact

HALF_WIDTH, DEPTH = 0.12, 0.10  # metres, of the station's body
TOUCH = 3e-3  # metres; a body that is stopped by something stands a little before it


class ChargingDock:
    """A dock at a true pose. radius: of the robot, metres; contact: tolerances of the charging contacts."""

    def __init__(self, dock: Pose, radius: float, contact: Contact):
        self.dock, self.radius, self.contact = dock, radius, contact
        self.emitter = Pose(dock.x - radius * math.cos(dock.yaw), dock.y - radius * math.sin(dock.yaw), dock.yaw)

    @property
    def outline(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The station's bounding rectangle in the scene: low and high corner, metres."""
        cosine, sine = math.cos(self.dock.yaw), math.sin(self.dock.yaw)
        corners = [(self.dock.x + cosine * x - sine * y, self.dock.y + sine * x + cosine * y)
                   for x in (-self.radius - DEPTH, -self.radius) for y in (-HALF_WIDTH, HALF_WIDTH)]
        return (min(x for x, _ in corners), min(y for _, y in corners)), (
            max(x for x, _ in corners), max(y for _, y in corners))

    def relative(self, pose: Pose) -> Pose:
        """A pose in the dock's frame; its yaw is 0 for a robot that faces the station."""
        return in_dock_frame(self.dock, pose)

    def touched(self, pose: Pose) -> bool:
        """True when the robot's disc touches the station."""
        return math.hypot(*self._nearest(pose)) <= self.radius + TOUCH

    def direction(self, pose: Pose) -> float:
        """The direction from a pose to the nearest point of the station, radians in the scene's frame."""
        x, y = self._nearest(pose)
        return math.atan2(y, x) + self.dock.yaw

    def _nearest(self, pose: Pose) -> tuple[float, float]:
        """From the robot's centre to the nearest point of the station's body, in the dock's frame."""
        x, y, _ = self.relative(pose)
        front = -self.radius
        return min(max(x, front - DEPTH), front) - x, min(max(y, -HALF_WIDTH), HALF_WIDTH) - y

    def charging(self, pose: Pose) -> bool:
        """True when the contacts meet, within the tolerances of `contact`."""
        x, y, yaw = self.relative(pose)
        return (self.touched(pose) and x > -0.05 and abs(y) <= self.contact.across
                and abs(math.degrees(yaw)) <= self.contact.angle)


def in_dock_frame(dock: Pose, pose: Pose) -> Pose:
    """Transform a pose into the frame of a dock: x away from it, yaw 0 facing it."""
    dx, dy = pose.x - dock.x, pose.y - dock.y
    cosine, sine = math.cos(dock.yaw), math.sin(dock.yaw)
    return Pose(cosine * dx + sine * dy, cosine * dy - sine * dx, wrapped(pose.yaw - dock.yaw - math.pi))
