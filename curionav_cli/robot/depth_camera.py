"""The depth image as a planar scan: what of it stands in the robot's way, column by column."""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.robot.measurements import Scan

LOWEST = 0.03  # metres; what is lower is floor


class DepthCamera:
    """A level camera at a height of `camera` metres, `fov` degrees wide and high, with images of side x side pixels.

    tallest: metres; what hangs higher is not in the way. far: metres; depth ends there. near: metres from which on the
    floor is seen.
    """

    def __init__(self, fov: float, camera: float, tallest: float, side: int = 64, far: float = 10.0):
        tangent = math.tan(math.radians(fov) / 2.0)
        across = tangent * ((np.arange(side) + 0.5) / (side / 2) - 1.0)  # (side,) to the right, a metre of depth
        self.camera, self.tallest, self.far, self.near = camera, tallest, far, camera / tangent
        self.rise = -across[:, None]  # (side, 1) upwards, a metre of depth
        self.bearing, self.stretch = -np.arctan(across), np.sqrt(1.0 + across**2)

    def scan(self, depth: np.ndarray) -> Scan:
        """depth (side, side) metres along the optical axis to `side` ranges; `far` where nothing stands in the way."""
        height = self.camera + self.rise * depth
        solid = (height > LOWEST) & (height < self.tallest) & (depth < self.far)
        nearest = np.where(solid, depth, np.float32(self.far)).min(axis=0)
        return Scan(self.bearing, nearest * self.stretch, 0.0)
