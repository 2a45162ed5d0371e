"""Frontier-based exploration on the robot's own map, without privileges and without learning."""

from __future__ import annotations

from typing import TYPE_CHECKING

from curionav_cli.agents.mapper import settings
from curionav_cli.agents.setup import Setup

if TYPE_CHECKING:
    from curionav_cli.agents.agent import Agent


def make(own: settings.Mapper, setup: Setup) -> Agent:
    """The agent gets numbers of its own robot: camera, radius, and the side of the cells that coverage counts."""
    from curionav_cli.agents.mapper.agent import Mapper
    from curionav_cli.agents.mapper.memory import Memory
    from curionav_cli.robot.depth_camera import DepthCamera

    scene = setup.scene
    camera = DepthCamera(scene.fov, scene.camera, scene.agent_height)
    return Mapper(setup.seed, camera, Memory(scene.plan.cell, own.reach, scene.plan.radius), own.goal.value)
