"""A real floor, env=live: what is known of it beforehand, which is little. It cannot be drawn."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace

import numpy as np

from curionav_cli.records import FloorPlan, Pose
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.settings import Live

LIVE_ONLY = ("floor", "extent")


@dataclass(frozen=True)
class RealFloor:
    """A real floor. plan: the cells of a ROS map of it, or a frame of cells around the start that is not bounded.

    fov: degrees, of the robot's camera; camera: metres, its height; agent_height: metres, what hangs higher is not in
    the robot's way.
    """

    plan: FloorPlan
    fov: float
    camera: float
    agent_height: float

    @classmethod
    def of(cls, env: Live) -> RealFloor:
        """The floor of these settings. Raises MapError or SceneError for a map that cannot be used."""
        return cls(mapped(env) if env.floor else frame(env), env.fov, env.camera, env.agent_height)


def mapped(env: Live) -> FloorPlan:
    """The floor plan of the ROS map env.floor. Raises MapError or SceneError."""
    own = {key: value for key, value in asdict(env).items() if key not in LIVE_ONLY}
    plan = Scene.from_dict({**own, "map": env.floor}, f"env.floor={env.floor}").plan
    return replace(plan, dock=plan.start)


def frame(env: Live) -> FloorPlan:
    """A square of cells with the start in its middle, facing along x; every cell counts."""
    cell = env.cell or 0.1
    side = 2 * round(env.extent / cell)
    everywhere = np.ones((side, side), bool)
    start = Pose(0.5 * side * cell, 0.5 * side * cell, 0.0)
    return FloorPlan(visitable=everywhere, floor=everywhere, solid=~everywhere, cell=cell, start=start,
                     radius=env.radius, name=env.name, dock=start, bounded=False)
