"""A mapping explorer that goes where its world model was, or should be, surprised."""

from __future__ import annotations

from typing import TYPE_CHECKING

from curionav_cli.agents.curious_mapper import settings
from curionav_cli.agents.setup import Setup

if TYPE_CHECKING:
    from curionav_cli.agents.agent import Agent


def make(own: settings.CuriousMapper, setup: Setup) -> Agent:
    """The agent gets numbers of its own robot: camera, radius, and the side of the cells that coverage counts."""
    from curionav_cli.agents.curious_mapper.agent import CuriousMapper
    from curionav_cli.agents.curious_mapper.driver import Driver
    from curionav_cli.agents.curious_mapper.memory import SurpriseMemory
    from curionav_cli.robot.depth_camera import DepthCamera

    scene = setup.scene
    memory = SurpriseMemory(scene.plan.cell, own.reach, scene.plan.radius, own.sight, own.optimism)
    driver = Driver(setup.seed, DepthCamera(scene.fov, scene.camera, scene.agent_height), memory, own.stay,
                    own.surprise)
    return CuriousMapper(own, setup.seed, setup.device, scene.plan, setup.compile, driver)
