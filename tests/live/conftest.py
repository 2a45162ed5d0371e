"""Real robots of each profile, simulated behind topics in memory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache

import pytest
from body import Body

from curionav_cli.config.compose import composed
from curionav_cli.config.schema import Config
from curionav_cli.live.env import LiveRobot
from curionav_cli.world.real_floor import RealFloor

PROFILES = ("turtlebot2i", "turtlebot3", "turtlebot4")


@lru_cache
def settings_of(profile: str, *words: str) -> Config:
    """The settings of a profile as shipped, and `words`."""
    return composed("explore", "env=live", "robot=rosbridge", f"robot/profile={profile}", *words)


@pytest.fixture
def robot() -> Callable[..., tuple[LiveRobot, Body]]:
    """robot(kind, **changes): the environment and the body behind it; changes: of the settings."""
    def make(kind: str, /, person: list[str] | None = None, **changes) -> tuple[LiveRobot, Body]:
        settings = settings_of(kind)
        live = replace(settings.robot, **changes)
        body = Body(live)
        asked = person if person is not None else []
        env = LiveRobot(RealFloor.of(settings.env), live, body.link, body, asked.append)
        return env, body
    return make
