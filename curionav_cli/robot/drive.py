"""The simulated differential drive and its errors: noise, veer, contact, slip."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from curionav_cli.records import Pose
from curionav_cli.robot.collision_world import CollisionWorld
from curionav_cli.robot.settings import Drive as Settings

PUSH = 0.25  # metres of blocked way that twist the base by the given standard deviation


class Motion(NamedTuple):
    """The true motion. rolled: metres of the wheels, slip included; turned: radians; touched: was the way blocked?"""

    pose: Pose
    rolled: float
    turned: float
    touched: bool


class Drive:
    """Moves a disc of `radius` metres through a CollisionWorld."""

    def __init__(self, settings: Settings, radius: float, generator: np.random.Generator):
        self.settings, self.radius, self.rng = settings, radius, generator

    def move(self, pose: Pose, distance: float, turn: float, world: CollisionWorld) -> Motion:
        """Execute a command: a short arc, a straight move or a turn on the spot, in metres and radians."""
        settings = self.settings
        forward, veer, turned = self.rng.standard_normal(3).tolist()
        root = math.sqrt(abs(distance))
        way = distance + forward * settings.forward * root
        turn += math.radians(veer * settings.veer * root + turned * settings.turn * math.sqrt(abs(turn)))
        heading = pose.yaw + 0.5 * turn
        ux, uy = math.copysign(1.0, way) * math.cos(heading), math.copysign(1.0, way) * math.sin(heading)
        free = world.travel(pose.x, pose.y, abs(way) * ux, abs(way) * uy, self.radius)
        rolled, touched = way, free < abs(way)
        if touched:
            rolled, turn = self.slip(way, free, turn)
        return Motion(Pose(pose.x + free * ux, pose.y + free * uy, pose.yaw + turn), rolled, turn, touched)

    def slip(self, way: float, free: float, turn: float) -> tuple[float, float]:
        """(rolled, turned) of a move of which only `free` metres can be driven: the wheels slip and the base twists."""
        settings, blocked = self.settings, abs(way) - free
        share = self.rng.uniform(settings.slip_least, settings.slip_most)
        twist = self.rng.normal(0.0, math.radians(settings.twist)) * math.sqrt(blocked / PUSH)
        return math.copysign(free + share * blocked, way), turn + twist
