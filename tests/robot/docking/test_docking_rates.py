"""Success follows from geometry: more error of the estimate is not better, more recoveries not worse."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from dockside import Dockside

import curionav_cli
from curionav_cli.robot.docking_settings import Recovery

SEEDS = range(12)


def docked(aside: float, recoveries: list[Recovery]) -> list[bool]:
    """Returns of a robot that stands `aside` metres to the right of its estimate."""
    robots = (Dockside(at=(1.2, -aside, 0.0), estimate_error=(0.0, aside), seed=seed, recoveries=recoveries)
              for seed in SEEDS)
    return [robot.send_goal().result() == "docked" for robot in robots]


@pytest.fixture(scope="module")
def alone() -> dict[float, list[bool]]:
    return {aside: docked(aside, []) for aside in (0.0, 0.3, 0.7)}


def test_the_larger_the_error_of_the_estimate_the_fewer_dock(alone: dict[float, list[bool]]) -> None:
    near, off, far = (sum(found) for found in alone.values())
    assert near >= off >= far
    assert near >= 10 and far <= 2


def test_a_recovery_never_costs_a_success(alone: dict[float, list[bool]]) -> None:
    """The first attempts are the same to the bit, so whoever docked without a recovery docks with one."""
    more = docked(0.3, [Recovery.restage, Recovery.sidestep_left])
    assert all(with_more >= without for with_more, without in zip(more, alone[0.3], strict=True))
    assert sum(more) >= sum(alone[0.3])


def test_the_same_seed_gives_the_same_return() -> None:
    ends = [Dockside(at=(1.6, 0.2, 90.0), seed=5).send_goal() for _ in range(2)]
    assert ends[0].result() == ends[1].result()
    assert ends[0].body.pose == ends[1].body.pose and ends[0].server.seconds == ends[1].server.seconds


def test_navigation_and_docking_draw_no_random_numbers() -> None:
    """None of these modules has a generator: noise is the body's, missed frames are the light's."""
    room = Path(curionav_cli.__file__).parent / "robot"
    for path in [*room.glob("docking/*.py"), room / "navigation.py", room / "planner.py", room / "charging_dock.py"]:
        names = {node.attr for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Attribute)}
        assert not names & {"random", "normal", "standard_normal", "uniform", "integers", "choice", "default_rng"}
