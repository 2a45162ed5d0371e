"""Small records for tests: episodes and plans of any size, a map."""

import numpy as np
import pytest
from office import write_two_rooms

from curionav_cli.records import Episode, FloorPlan, Pose


@pytest.fixture(scope="session")
def an_episode():
    """an_episode(steps=5): noise for images, a straight walk for poses."""
    def make(steps=5, events=(), seed=0):
        rng = np.random.default_rng(seed)
        pose = np.column_stack([np.linspace(0.2, 0.4, steps + 1), np.full(steps + 1, 0.3), np.zeros(steps + 1)])
        return Episode(rng.integers(0, 256, (steps + 1, 64, 64, 3), np.uint8), rng.integers(0, 3, steps), pose,
                       rng.random(steps) < 0.2, tuple(events))
    return make


@pytest.fixture(scope="session")
def a_plan():
    """a_plan(rows, columns): an open room; with hole=True a solid block that the robot keeps away from."""
    def make(rows=4, columns=6, cell=0.1, radius=0.18, hole=False):
        solid = np.zeros((rows, columns), bool)
        floor = np.ones((rows, columns), bool)
        if hole:
            solid[rows // 2, columns // 2] = True
        visitable = floor & ~solid
        return FloorPlan(visitable, floor, solid, cell, Pose(cell / 2, cell / 2, 0.0), radius, "a_plan")
    return make


@pytest.fixture(scope="session")
def a_map(tmp_path_factory):
    """The YAML file of a ROS map of two rooms."""
    return str(write_two_rooms(tmp_path_factory.mktemp("office")))
