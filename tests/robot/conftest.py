"""Profiles and scenes for the tests of this room."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hydra.types import RunMode

from curionav_cli.config.settings import as_settings
from curionav_cli.config.sources import MAIN, opened
from curionav_cli.robot.settings import Turtlebot
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain


def profile_of(*words: str) -> Turtlebot:
    with opened("explore") as hydra:
        return as_settings(hydra.compose_config(MAIN, list(words), RunMode.RUN)).robot


@pytest.fixture(scope="session")
def turtlebot() -> Turtlebot:
    """robot=turtlebot2i as shipped."""
    return profile_of("robot=turtlebot2i")


@pytest.fixture(scope="session")
def quiet(turtlebot) -> Turtlebot:
    """The same robot without any error: what is commanded happens, and what happens is measured."""
    return replace(
        turtlebot, drive=replace(turtlebot.drive, forward=0.0, veer=0.0, turn=0.0, twist=0.0),
        odometry=replace(turtlebot.odometry, scale=0.0, noise=0.0),
        gyro=replace(turtlebot.gyro, scale=0.0, noise=0.0, bias=0.0, walk=0.0),
        lidar=replace(turtlebot.lidar, noise=0.0), depth=replace(turtlebot.depth, noise=0.0))


@pytest.fixture(scope="session")
def small_room() -> Scene:
    return Scene.from_dict(*plain("small_room"))


@pytest.fixture(scope="session")
def large_lab() -> Scene:
    return Scene.from_dict(*plain("large_lab"))
