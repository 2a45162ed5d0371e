"""When the robot must stop, and faults: of the connection, of a sensor, of the odometry.

A move is refused or cut short, and the episode goes on:
    the way ahead shows an obstacle, or leaves the geofence     env.py (_forward)
    a bumper, a cliff, a stall; in moves ahead                  wheels.py (touched)
    a wheel drop; in every move                                 wheels.py (lifted)
    its time is over                                            wheels.py (limit)

The wheels stop and the episode ends, by a Fault, which every moment of a move looks for (LiveBase.pause):
    the connection is lost                                      base.py (pause)
    a message cannot be used, a topic is silent                 sensors.py (check)
    the odometry jumps (Displaced: a person is asked)           travel.py (check)
What catches it is env.py (step, _close_episode); between episodes `reset`, and the run ends with RunFailed.

The episode ends where the battery is down to the reserve: env.py (_battery_low). Any other exception, Ctrl-C and
SIGTERM (execution/interrupts.py) among them, stops the wheels on its way through `step`, `reset` and Wheels.act.
"""

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
