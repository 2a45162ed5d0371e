"""The mapping explorer: it covers what can be covered, by its camera and its pose alone, and notices change."""

from __future__ import annotations

import ast
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curionav_cli
from curionav_cli.agents.lattice import Lattice
from curionav_cli.agents.mapper.agent import Mapper
from curionav_cli.agents.mapper.goals import GOALS, frontiers
from curionav_cli.agents.mapper.memory import Memory
from curionav_cli.constants import FORWARD
from curionav_cli.files import write_arrays
from curionav_cli.records import Pose
from curionav_cli.robot.depth_camera import DepthCamera
from curionav_cli.robot.measurements import Scan
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.scene.scene import Scene

PACKAGE = Path(curionav_cli.__file__).parent
TWO_ROOMS: dict[str, Any] = {
    "name": "two", "size": [3.0, 2.0], "cell": 0.1, "radius": 0.15, "camera": 0.45, "height": 2.4,
    "start": [0.5, 0.5, 0], "walls": [{"line": [1.7, 0.0, 1.7, 2.0], "gaps": [[0.6, 0.9]]}],
    "furniture": [{"kind": "box", "x": 2.5, "y": 1.2, "name": "box"}],
}
MOVING = {**TWO_ROOMS, "moves": [{"item": "box", "every": 1, "to": [[0.5, 1.5], [2.5, 0.5]]}]}


def mapper(scene: Scene, goal: str = "unvisited") -> Mapper:
    camera = DepthCamera(scene.fov, scene.camera, scene.agent_height)
    return Mapper(0, camera, Memory(scene.plan.cell, 4.0, scene.plan.radius), goal)


def explore(agent: Mapper, env: NavigationEnv, steps: int, episodes: int = 1, first: int = 0) -> dict[str, Any]:
    """(rows, columns) landed; cancelled: of the moves in each episode."""
    plan = env.scene.plan
    landed, cancelled = np.zeros(plan.visitable.shape, bool), []
    observation, info = env.reset(seed=0, options={"episode": first})
    for episode in range(first, first + episodes):
        agent.begin()
        stopped = 0
        for _ in range(steps):
            observation, *_, info = env.step(agent.act(observation, info))
            landed[plan.cells(*info["pose"][:2])] = True
            stopped += bool(info["collided"])
        cancelled.append(stopped)
        observation, info = env.reset(options={"episode": episode + 1})
    return {"landed": landed, "cancelled": cancelled}


@pytest.fixture(scope="module")
def explored() -> tuple[Mapper, NavigationEnv, dict[str, Any]]:
    env = NavigationEnv(Scene.from_dict(TWO_ROOMS))
    agent = mapper(env.scene)
    return agent, env, explore(agent, env, 1200)


def test_it_covers_most_of_what_the_oracle_covers(explored) -> None:
    """The oracle lands on 287 cells in as many steps."""
    _, env, done = explored
    assert (done["landed"] & env.scene.plan.visitable).sum() > 0.7 * 287


def test_it_says_when_nothing_is_left_and_goes_on() -> None:
    closet = {**TWO_ROOMS, "size": [1.0, 0.8], "walls": [], "furniture": [], "start": [0.5, 0.4, 0]}
    env = NavigationEnv(Scene.from_dict(closet))
    agent = mapper(env.scene)
    assert agent.report() == {}
    done = explore(agent, env, 600)
    visitable = env.scene.plan.visitable
    assert (done["landed"] & visitable).sum() > 0.9 * visitable.sum()
    assert 0 < agent.report()["explored"] <= 600


def test_its_map_is_the_room(explored) -> None:
    agent, env, _ = explored
    plan = env.scene.plan
    rows, columns = np.nonzero(plan.visitable)
    assert agent.memory.free[agent.memory.map.cells((columns + 0.5) * 0.1, (rows + 0.5) * 0.1)].mean() > 0.97
    wall = agent.memory.map.cells(np.full(5, 1.68), np.linspace(0.1, 0.5, 5))
    assert agent.memory.map.occupied[wall].mean() >= 0.8


def test_it_goes_on_to_the_byte_from_what_it_saved(explored, tmp_path: Path) -> None:
    agent, env, _ = explored
    agent.save(tmp_path)
    other = mapper(env.scene)
    other.load(tmp_path)
    for name in Memory.GRIDS:
        np.testing.assert_array_equal(getattr(other.memory, name), getattr(agent.memory, name))
    one, two = (explore(each, NavigationEnv(env.scene), 40, first=1) for each in (agent, other))
    np.testing.assert_array_equal(one["landed"], two["landed"])
    assert other.report() == agent.report()


def test_a_checkpoint_of_an_earlier_version_is_read(explored, tmp_path: Path) -> None:
    agent, env, _ = explored
    agent.save(tmp_path)
    write_arrays(tmp_path / "map.npz", {name: agent.memory.save()[name] for name in Memory.SAVED})
    other = mapper(env.scene)
    other.load(tmp_path)
    assert not other.memory.blocked.any() and not other.memory.clearance.point.any()
    np.testing.assert_array_equal(other.memory.visited, agent.memory.visited)
    assert not other.memory.free.all()


def test_what_was_carried_away_is_driven_through_again() -> None:
    """The box stands elsewhere in every episode, and only where it stands now are moves cancelled."""
    env = NavigationEnv(Scene.from_dict(MOVING))
    agent = mapper(env.scene)
    done = explore(agent, env, 400, episodes=6)
    visitable = env.scene.plan.visitable
    assert (done["landed"] & visitable).sum() > 0.95 * visitable.sum()
    assert sum(done["cancelled"][3:]) < 0.1 * 400 * 3


def test_a_belief_that_turned_a_little_is_planned_from() -> None:
    """Headings of a robot that drifts are off the table; the search takes those that it has."""
    env = NavigationEnv(Scene.from_dict(TWO_ROOMS))
    agent = mapper(env.scene)
    observation, info = env.reset(seed=0)
    agent.begin()
    info = {**info, "estimate": info["pose"] + [0.01, -0.01, math.radians(3.0)]}
    actions = []
    for _ in range(3):
        actions.append(agent.act(observation, info))
    assert FORWARD in actions
    assert agent.memory.visited[agent.memory.map.cells(0.51, 0.49)]


@pytest.mark.parametrize("goal", GOALS)
def test_every_goal_leads_through_the_door(goal: str) -> None:
    env = NavigationEnv(Scene.from_dict(TWO_ROOMS))
    done = explore(mapper(env.scene, goal), env, 400)
    assert done["landed"][:, 19:].any(), "it saw the other room"


def looked_around(reach: float) -> Memory:
    """A memory that has seen a disc of floor around the origin and no obstacle."""
    memory = Memory(0.1, reach, 0.15)
    bearing = np.linspace(-math.pi, math.pi, 360, endpoint=False)
    memory.see(Pose(0.05, 0.05, 0.0), Scan(bearing, np.full(360, 10.0), 0.0), 0.0)
    return memory


def test_the_map_grows_and_keeps_what_it_knows() -> None:
    memory = looked_around(2.0)
    memory.cancelled(0.05, 0.05, 0.0)
    memory.land(0.05, 0.05, (0.05, 0.05))
    [[row, column]] = np.argwhere(memory.closed)
    at = [memory.map.corner[0] + (column + 0.5) * 0.1], [memory.map.corner[1] + (row + 0.5) * 0.1]
    small = memory.map.odds.size
    for pose in (Pose(-9.0, 0.05, 0.0), Pose(0.05, -9.0, 0.0)):
        memory.see(pose, Scan(np.array([0.0]), np.array([1.0]), 0.0), 0.0)
    assert memory.map.odds.size > small
    assert memory.closed[memory.map.cells(*at)].all() and memory.closed.sum() == 1
    assert memory.visited[memory.map.cells(0.05, 0.05)] and memory.visited.sum() == 1
    assert memory.clearance.count[memory.map.cells(*at)] > 0 and not memory.free[memory.map.cells(*at)].any()


def test_obstacles_fade_when_an_episode_begins() -> None:
    memory = Memory(0.1, 4.0, 0.15)
    wall, floor = (Scan(np.array([0.0]), np.array([length]), 0.0) for length in (2.0, 9.0))
    for step in range(9):
        memory.see(Pose(-0.3 * (step % 2), 0.05, 0.0), wall, 0.0)
        wall = Scan(wall.bearing, 2.0 + 0.3 * (np.array([step + 1]) % 2), 0.0)
    assert not memory.free[memory.map.cells(2.05, 0.05)]
    memory.begin()
    assert not memory.free[memory.map.cells(2.05, 0.05)], "it stands until the floor is seen there"
    for step in range(2):
        memory.see(Pose(-0.3 * (step % 2), 0.05, 0.0), floor, 0.0)
    assert memory.free[memory.map.cells(2.05, 0.05)]


def test_a_goal_that_was_blocked_before_counts_as_further_away() -> None:
    """Two cells to go to, one 2 and one 6 moves ahead: the near one is chosen, until it was blocked often enough."""
    free, goal, further = np.ones((3, 40), bool), np.zeros((3, 40), bool), np.zeros((3, 40), np.int16)
    goal[1, [7, 17]] = True
    lengths = []
    for blocked in (0, 3, 5):
        further[1, 7] = blocked
        lengths.append(len(Lattice(free, goal, 0.1, further=further).search(0.25, 0.15, 0)))
    assert lengths == [2, 2, 6]
    goal[1, 17] = False
    assert len(Lattice(free, goal, 0.1, further=further).search(0.25, 0.15, 0)) == 2, "nothing else is left"


def test_it_counts_the_episodes_that_ended_with_a_cell_blocked() -> None:
    memory = looked_around(2.0)
    memory.cancelled(0.05, 0.05, 0.0)
    memory.land(0.05, 0.05, (0.05, 0.05))
    shut = ~memory.free
    for _ in range(2):
        memory.begin()
    assert shut.any() and (memory.blocked == shut).all(), "an episode in which nothing was done counts for nothing"


def test_a_robot_that_is_shut_in_looks_again() -> None:
    """Obstacles that are not there surround it; the map was wrong, and nothing is called explored."""
    env = NavigationEnv(Scene.from_dict(TWO_ROOMS))
    agent = mapper(env.scene)
    explore(agent, env, 150)
    x, y = env.scene.plan.start[:2]
    row, column = agent.memory.map.cells(x, y)
    ring = np.hypot(*np.indices(agent.memory.map.odds.shape) - np.array([row, column])[:, None, None])
    agent.memory.map.odds[(ring > 4) & (ring < 6)] = 3.5
    agent.memory.passed[:] = False
    before = agent.memory.visited.sum()
    explore(agent, env, 150, first=1)
    assert agent.memory.visited.sum() > before and agent.report() == {}


def test_the_lidar_is_entered_where_the_robot_has_one() -> None:
    env = NavigationEnv(Scene.from_dict(TWO_ROOMS))
    observation, info = env.reset(seed=0)
    behind = np.stack([np.full(3, math.pi), [0.5, np.nan, 0.5]])
    known = []
    for scan in ({}, {"lidar": behind}):
        agent = mapper(env.scene)
        agent.begin()
        agent.act(observation, {**info, **scan})
        known.append([bool(agent.memory.map.known[agent.memory.map.cells(x, 0.5)]) for x in (0.25, 0.05)])
        occupied = bool(agent.memory.map.occupied[agent.memory.map.cells(-0.005, 0.5)])
        assert occupied == bool(scan)
    assert known == [[False, False], [True, True]], "the camera looks the other way"


def test_frontiers_are_the_rim_of_what_is_known() -> None:
    memory = looked_around(1.5)
    label, sizes = frontiers(memory)
    rows, columns = np.nonzero(label)
    away = np.hypot((columns + 0.5) * 0.1 + memory.map.corner[0], (rows + 0.5) * 0.1 + memory.map.corner[1])
    assert len(away) > 40 and away.min() > 0.9 and sizes[0] == 0 and sizes.sum() == len(rows)


def test_a_short_frontier_is_no_goal_and_information_takes_what_shows_most() -> None:
    memory = Memory(0.1, 4.0, 0.15)
    memory.map.odds[20:60, 20:60], memory.map.odds[19:61, 19], memory.map.odds[19:61, 60] = -1.0, 3.5, 3.5
    memory.map.odds[19, 19:61], memory.map.odds[60, 19:61] = 3.5, 3.5
    for row, columns in ((60, slice(30, 50)), (19, slice(24, 36)), (19, slice(46, 49))):  # gaps of 2.0, 1.2 and 0.3 m
        memory.map.odds[row, columns] = 0.0
    memory.map.odds[4:18, 22:38] = 3.5  # known, so that the second gap shows less
    memory.clearance.follow(memory.map.occupied)
    near, most = (GOALS[goal](memory, 0.05, 0.05) for goal in ("frontier", "information"))
    assert near[59, 30:50].any() and near[20, 24:36].any() and not near[20, 44:52].any()
    assert most[59, 30:50].any() and not most[20].any()


def test_a_cancelled_move_closes_one_cell_until_nothing_is_near_it() -> None:
    memory = looked_around(4.0)
    memory.cancelled(0.05, 0.05, 0.0)
    [[row, column]] = np.argwhere(memory.closed)
    x, y = memory.map.corner[0] + (column + 0.5) * 0.1, memory.map.corner[1] + (row + 0.5) * 0.1
    assert not memory.free[memory.map.cells(x, y)]
    bearing = np.linspace(-math.pi, math.pi, 360, endpoint=False)
    for turn in range(16):  # the floor is seen again, from other places
        memory.see(Pose(-1.0 + 0.3 * (turn % 2), 0.05, 0.0), Scan(bearing, np.full(360, 10.0), 0.0), 0.0)
    assert memory.free[memory.map.cells(x, y)] and memory.closed[memory.map.cells(x, y)]


def test_the_camera_tells_floor_obstacles_and_lintels_apart() -> None:
    camera = DepthCamera(fov=90.0, camera=0.5, tallest=1.0)
    floor = np.where(camera.rise < 0, 0.5 / np.maximum(-camera.rise, 1e-9), np.inf)
    depth = np.minimum(np.broadcast_to(floor, (64, 64)), 10.0).astype(np.float32)
    assert camera.near == pytest.approx(0.5)
    np.testing.assert_allclose(camera.scan(depth).range, 10.0 * camera.stretch, rtol=1e-6)
    box = depth.copy()
    box[:, 20:30] = np.minimum(box[:, 20:30], np.where(np.abs(camera.rise * 2.0 + 0.35) < 0.15, 2.0, 10.0))
    seen = camera.scan(box)
    np.testing.assert_allclose(seen.range[20:30], 2.0 * camera.stretch[20:30], rtol=1e-6)
    assert seen.bearing[20] > 0 > seen.bearing[40], "to the left is positive"
    lintel = np.where(camera.rise * 2.0 + 0.5 > 1.0, np.float32(2.0), depth)
    np.testing.assert_allclose(camera.scan(lintel).range, 10.0 * camera.stretch, rtol=1e-6)


def imported(name: str, seen: set[str]) -> set[str]:
    """Every module of the package that this one imports, and what those import."""
    path = PACKAGE / f"{name.replace('.', '/')}.py"
    if name in seen or not path.is_file():
        return seen
    seen.add(name)
    for node in ast.walk(ast.parse(path.read_text())):
        names = [f"{node.module}.{alias.name}" for alias in node.names] + [str(node.module)] \
            if isinstance(node, ast.ImportFrom) else [alias.name for alias in node.names] \
            if isinstance(node, ast.Import) else []
        for one in names:
            if one.startswith("curionav_cli."):
                imported(one.removeprefix("curionav_cli."), seen)
    return seen


def test_it_cannot_import_the_scene() -> None:
    everything = imported("agents.mapper.agent", set())
    assert "agents.mapper.memory" in everything and "robot.occupancy" in everything
    assert not [name for name in everything if name.rpartition(".")[2] in ("scene", "env", "build", "simulated_robot",
                                                                          "body", "surroundings", "collision_world")]
