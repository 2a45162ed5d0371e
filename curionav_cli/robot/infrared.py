"""The dock's infrared light and the robot's three receivers, from true geometry (Kobuki: vendor's documentation).

The dock lights three sectors, left, centre and right as seen from the dock, each near and far; neighbouring sectors
overlap a little. A receiver sees a sector if the robot stands in it, nothing is in between and the dock lies in the
receiver's field. A frame may be missed; what was seen counts for the next FILTER frames.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable

import numpy as np

from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.charging_dock import ChargingDock
from curionav_cli.robot.docking_settings import InfraredLight
from curionav_cli.robot.measurements import CENTRE, LEFT, NEAR, RIGHT, Signals

FILTER = 4  # frames at 10 Hz: the 0.4 s over which the drive collects its signals

Sight = Callable[[float, float, float, float], bool]  # is the straight line between two points free?


class Infrared:
    """The simulated receivers. light: widths and ranges of sectors and receivers; sight: is a line of sight free?"""

    def __init__(self, light: InfraredLight, station: ChargingDock, generator: np.random.Generator, sight: Sight):
        self.light, self.station, self.generator, self.sight = light, station, generator, sight
        self._recent: deque[Signals] = deque(maxlen=FILTER)
        self._fields = tuple((math.radians(axis), math.radians(half)) for axis, half in (
            (-light.side_axis, light.side_width), (0.0, light.centre_width), (light.side_axis, light.side_width)))

    def receive(self, pose: Pose) -> Signals:
        """Add the frame at this true pose; returns the signals of the last FILTER frames together."""
        self._recent.append(self.frame(pose))
        right = centre = left = 0
        for frame in self._recent:
            right, centre, left = right | frame[0], centre | frame[1], left | frame[2]
        return right, centre, left

    def frame(self, pose: Pose) -> Signals:
        """The signals of a single frame at this true pose."""
        dock = self.station.emitter
        towards = math.atan2(dock.y - pose.y, dock.x - pose.x)
        bits = sectors(self.light, math.hypot(dock.x - pose.x, dock.y - pose.y), wrapped(towards + math.pi - dock.yaw))
        if not bits or not self.sight(pose.x, pose.y, dock.x, dock.y):
            return 0, 0, 0
        bearing = wrapped(towards - pose.yaw)
        missed = self.generator.random(3) < self.light.missed
        right, centre, left = (
            0 if lost or abs(wrapped(bearing - axis)) > half else bits
            for (axis, half), lost in zip(self._fields, missed.tolist(), strict=True))
        return right, centre, left


def sectors(light: InfraredLight, distance: float, angle: float) -> int:
    """Bits of the sectors at `distance` metres from the dock, `angle` radians to the left of its axis."""
    angle = math.degrees(angle)
    if distance > light.range or abs(angle) > light.cone:
        return 0
    bits = (CENTRE if abs(angle) <= light.centre_sector + light.overlap else 0) | (
        LEFT if angle >= light.centre_sector else 0) | (RIGHT if angle <= -light.centre_sector else 0)
    return bits & NEAR if distance <= light.near else bits & ~NEAR
