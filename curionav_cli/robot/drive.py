"""How a differential drive falls short of its commands: spread, veer, contact, slip."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from curionav_cli.records import Pose
from curionav_cli.robot.collision_world import CollisionWorld
from curionav_cli.robot.settings import Drive as Settings

PUSH = 0.25  # metres of blocked way that twist the base by the given standard deviation


class Motion(NamedTuple):
    """What truly happened. rolled: metres that the wheels turned, slip included; turned: radians."""

    pose: Pose
    rolled: float
    turned: float
    touched: bool


class Drive:
    """Moves a disc of `radius` metres through its surroundings."""

    def __init__(self, settings: Settings, radius: float, generator: np.random.Generator):
        self.settings, self.radius, self.rng = settings, radius, generator

    def move(self, pose: Pose, distance: float, turn: float, around: CollisionWorld) -> Motion:
        """A short arc, or a whole straight move, or a turn on the spot; commands in metres and radians."""
        settings = self.settings
        forward, veer, turned = self.rng.standard_normal(3).tolist()
        root = math.sqrt(abs(distance))
        way = distance + forward * settings.forward * root
        turn += math.radians(veer * settings.veer * root + turned * settings.turn * math.sqrt(abs(turn)))
        heading = pose.yaw + 0.5 * turn
        ux, uy = math.copysign(1.0, way) * math.cos(heading), math.copysign(1.0, way) * math.sin(heading)
        free = around.travel(pose.x, pose.y, abs(way) * ux, abs(way) * uy, self.radius)
        rolled, touched = way, free < abs(way)
        if touched:
            rolled, turn = self.slip(way, free, turn)
        return Motion(Pose(pose.x + free * ux, pose.y + free * uy, pose.yaw + turn), rolled, turn, touched)

    def slip(self, way: float, free: float, turn: float) -> tuple[float, float]:
        """What the wheels roll and how the base turns when only `free` metres of the way can be driven."""
        settings, blocked = self.settings, abs(way) - free
        share = self.rng.uniform(settings.slip_least, settings.slip_most)
        twist = self.rng.normal(0.0, math.radians(settings.twist)) * math.sqrt(blocked / PUSH)
        return math.copysign(free + share * blocked, way), turn + twist
