"""The occupancy grid and the planner on it: against rooms whose walls are given, and a plain search."""

from __future__ import annotations

import ast
import heapq
import math
from pathlib import Path

import numpy as np
import pytest

import curionav_cli
from curionav_cli.records import Pose
from curionav_cli.robot.measurements import Scan
from curionav_cli.robot.occupancy import BLOCK, Occupancy
from curionav_cli.robot.planner import NEIGHBOURS, nearest_open, plan, prices

BEARING = np.linspace(-math.pi, math.pi, 180, endpoint=False) + 0.01


def square_room(half: float, x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> Scan:
    """What a scanner sees at a pose in a square room around the origin."""
    cosine, sine = np.cos(BEARING + yaw), np.sin(BEARING + yaw)
    along_x, along_y = (np.sign(cosine) * half - x) / cosine, (np.sign(sine) * half - y) / sine
    return Scan(BEARING, np.fmin(along_x, along_y), 0.0)


def drawn(picture: str) -> Occupancy:
    """A map from a drawing, top row first: # occupied, . free, blank unknown; its corner is the origin."""
    rows = picture.strip("\n").split("\n")[::-1]
    grid = Occupancy()
    odds = {"#": 2.0, ".": -2.0, " ": 0.0}
    grid.odds = np.array([[odds[mark] for mark in row.ljust(max(map(len, rows)))] for row in rows], np.float32)
    grid.corner = (0.0, 0.0)
    return grid


def test_a_scan_becomes_a_room() -> None:
    grid = Occupancy()
    for yaw in (0.0, 0.3, 1.2):
        grid.insert(Pose(0.3, -0.2, yaw), square_room(1.5, 0.3, -0.2, yaw))
    rows, columns = np.nonzero(grid.occupied)
    x, y = grid.corner[0] + (columns + 0.5) * grid.cell, grid.corner[1] + (rows + 0.5) * grid.cell
    assert len(x) > 80
    assert np.abs(np.maximum(np.abs(x), np.abs(y)) - 1.5).max() < 0.11
    inside = grid.cells(*np.meshgrid(np.linspace(-1.3, 1.3, 20), np.linspace(-1.3, 1.3, 20)))
    assert grid.known[inside].all() and not grid.occupied[inside].any()


def test_what_gives_no_return_and_what_is_far_is_no_obstacle() -> None:
    grid = Occupancy(reach=2.0)
    grid.insert(Pose(0.0, 0.0, 0.0), Scan(BEARING, np.where(BEARING < 0, np.nan, 5.0), 0.0))
    assert not grid.occupied.any()
    assert grid.known[grid.cells(0.0, 1.5)] and not grid.known[grid.cells(0.0, -1.5)]


def test_a_thing_that_was_carried_away_fades() -> None:
    grid = Occupancy()
    for _ in range(9):
        grid.insert(Pose(0.0, 0.0, 0.0), square_room(1.0))
    assert grid.occupied[grid.cells(1.0, 0.0)]
    for _ in range(9):
        grid.insert(Pose(0.0, 0.0, 0.0), square_room(2.0))
    assert not grid.occupied[grid.cells(1.0, 0.0)]


def test_the_map_grows_and_keeps_its_cells() -> None:
    grid = Occupancy()
    grid.insert(Pose(0.0, 0.0, 0.0), square_room(1.0))
    before = grid.occupied[grid.cells(*np.meshgrid(np.linspace(-1.2, 1.2, 60), np.linspace(-1.2, 1.2, 60)))]
    grid.insert(Pose(-20.0, 13.0, 0.0), square_room(1.0))
    after = grid.occupied[grid.cells(*np.meshgrid(np.linspace(-1.2, 1.2, 60), np.linspace(-1.2, 1.2, 60)))]
    assert (before == after).all() and grid.known[grid.cells(-20.0, 13.0)]
    assert all(side % BLOCK == 0 for side in grid.odds.shape)
    again = Occupancy.of(grid.save())
    assert again.corner == grid.corner and (again.odds == grid.odds).all()


def test_plans_cost_what_a_plain_search_finds() -> None:
    rng = np.random.default_rng(0)
    grid = drawn("\n".join("".join(rng.choice(list("....... #"), 24)) for _ in range(20)))
    price = prices(grid)
    found = plan(grid, 1.25, 0.95)
    goal = divmod(nearest_open(price, 9, 12), 24)
    cost = {goal: 0.0}
    queue = [(0.0, goal)]
    while queue:
        so_far, (row, column) = heapq.heappop(queue)
        if so_far > cost[row, column]:
            continue
        for down, right, length in NEIGHBOURS:
            for sign in (-1, 1):
                at = (row + sign * down, column + sign * right)
                if not (0 <= at[0] < 20 and 0 <= at[1] < 24) or not np.isfinite(price[at]):
                    continue
                further = so_far + 0.5 * length * (price[at] + price[row, column])
                if further < cost.get(at, math.inf) - 1e-12:
                    cost[at] = further
                    heapq.heappush(queue, (further, at))
    for at in np.ndindex(price.shape):
        assert found.cost[at] == pytest.approx(cost.get(at, math.inf) * 0.1)


WALLED = """
..........................
..........................
..........................
..........................
#########################.
..........................
..........................
..........................
..........................
"""


def test_a_path_goes_around_and_keeps_away_from_walls() -> None:
    grid = drawn(WALLED.replace("#.", "# ").replace("# ", "#."))
    wide = drawn("\n".join(row + "......" for row in WALLED.strip("\n").split("\n")))
    assert not np.isfinite(plan(grid, 0.25, 0.15).at(0.25, 0.85))  # a gap of 0.1 m lets no robot pass
    path = plan(wide, 0.25, 0.05).path(0.25, 0.85)
    assert path[0] == pytest.approx((0.25, 0.85)) and path[-1] == pytest.approx((0.25, 0.05))
    assert path[:, 0].max() > 2.6
    assert np.hypot(*np.diff(path, axis=0).T).max() < 0.15


def test_a_closed_goal_is_replaced_by_the_nearest_open_cell() -> None:
    grid = drawn(WALLED)
    path = plan(grid, 1.25, 0.55).path(0.25, 0.85)
    assert len(path) and path[-1][0] == pytest.approx(1.25, abs=0.11) and path[-1][1] >= 0.6


def test_unknown_ground_is_passable_but_dearer() -> None:
    grid = drawn("\n".join(["." * 30] * 8 + [" " * 30] * 8))
    assert plan(grid, 2.85, 0.35).at(0.15, 0.35) > 1.5 * plan(grid, 2.85, 1.25).at(0.15, 1.25)
    assert np.isfinite(plan(grid, 2.85, 0.35).cost).all()


def test_a_robot_that_stands_too_close_may_leave() -> None:
    grid = drawn(WALLED)
    at = (1.25, 0.55)  # right above the wall
    assert not np.isfinite(plan(grid, 0.25, 0.85).at(*at))
    assert np.isfinite(plan(grid, 0.25, 0.85, at).at(*at))
    assert not np.isfinite(plan(grid, 0.25, 0.85, at).at(1.25, 0.45))


@pytest.mark.parametrize("module", ["occupancy", "planner", "navigation", "docking/server", "docking/approach",
                                    "docking/client", "docking/recoveries", "docking/action", "interface",
                                    "localiser", "ekf"])
def test_planner_filter_and_docking_do_not_import_the_true_world(module: str) -> None:
    """Nothing that a module imports, at any distance, is the world or the true robot."""
    package = Path(curionav_cli.__file__).parent
    todo, seen = [package / "robot" / f"{module}.py"], set()
    while todo:
        path = todo.pop()
        seen.add(path)
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith("curionav_cli"):
                continue
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            files = {package.parent / f"{name.replace('.', '/')}.py" for name in names if name}
            todo += [file for file in files - seen if file.is_file()]
    inside = {path.relative_to(package).as_posix() for path in seen}
    assert f"robot/{module}.py" in inside
    assert not [name for name in inside if name.startswith("world/") or name == "robot/simulated_robot.py"
                or name in ("robot/collision_world.py", "robot/robot_base.py", "robot/charging_dock.py")]
