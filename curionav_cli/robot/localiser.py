"""Where the robot believes that it is, from what it sensed. Its frame is the scene's, since the one thing that it
is told is where its dock stands there."""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.config.robot_schema import Turtlebot
from curionav_cli.geometry import wrapped
from curionav_cli.records import Pose
from curionav_cli.robot.sensed import Scan, Sensed


class Localiser:
    """pose: estimated. covariance (3, 3): of x, y, yaw. lost: it no longer trusts itself."""

    def __init__(self, profile: Turtlebot, pose: Pose):
        self.profile, self.pose, self.lost = profile, Pose(*pose), False
        self.covariance = np.zeros((3, 3))

    def feel(self, sensed: Sensed, scan: Scan | None = None) -> None:
        """One more move, and what the LiDAR saw after it."""
        heading = self.pose.yaw + 0.5 * sensed.gyro
        self.pose = Pose(self.pose.x + sensed.wheel * math.cos(heading), self.pose.y + sensed.wheel * math.sin(heading),
                         wrapped(self.pose.yaw + sensed.gyro))

    def fix(self, pose: Pose, sd_position: float, sd_yaw: float) -> None:
        """It stands at a known pose, to so many metres and radians: the dock."""
        self.pose = Pose(*pose)
