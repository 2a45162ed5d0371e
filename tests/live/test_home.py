"""The way home of a real robot: docked by its own action, or back at its start, or carried by a person."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from body import DOCK, Body

from curionav_cli.constants import FORWARD, LEFT
from curionav_cli.errors import RunFailed
from curionav_cli.live.connect import ask
from curionav_cli.live.env import LiveRobot
from curionav_cli.records import DockReport
from curionav_cli.robot.docking.action import GoalState


def explore(env: LiveRobot) -> None:
    """Drive two metres into the room."""
    for action in (FORWARD, FORWARD, LEFT, LEFT, FORWARD, FORWARD, LEFT, FORWARD, FORWARD, FORWARD):
        env.step(action)


@pytest.mark.parametrize("profile", ["turtlebot2i", "turtlebot4"])
def test_it_docks_undocks_and_goes_on(robot, profile: str) -> None:
    asked: list[str] = []
    env, body = robot(profile, person=asked)
    _, info = env.reset(seed=0)
    assert info["dock"] is None and not body.docked
    explore(env)
    docked: list[float] = []
    body.watch.append(lambda: body.docked and docked.append(body.time))
    _, info = env.reset()
    report = DockReport.of(info["dock"])
    assert report.success and not report.human and report.attempts == 1 and report.metres > 1.0
    assert docked and not body.docked and not asked and info["episode_index"] == 1
    start = env.floor.plan.start
    found = info["pose"][:2] - (start.x, start.y)
    assert math.hypot(found[0] - (body.x - DOCK[0]), found[1] - (body.y - DOCK[1])) < 0.02  # corrected by the dock


def test_without_a_dock_it_drives_back_to_its_start(robot) -> None:
    env, body = robot("turtlebot3")
    env.reset(seed=0)
    explore(env)
    _, info = env.reset()
    assert math.hypot(body.x - DOCK[0], body.y - DOCK[1]) < 0.2 and abs(body.yaw) < 0.15
    assert info["dock"]["code"] == "docked" and "no dock" in info["dock"]["text"]


@pytest.mark.parametrize(("outcome", "code"), [
    (GoalState.aborted, "action_aborted"), (GoalState.preempted, "action_preempted"),
    (GoalState.rejected, "action_rejected"), (GoalState.lost, "action_lost"),
])
def test_a_docking_action_that_fails_is_tried_again_then_a_person_is_asked(robot, outcome, code: str) -> None:
    asked: list[str] = []
    env, body = robot("turtlebot4", person=asked)
    env.reset(seed=0)
    env.step(FORWARD)
    body.outcome = {"dock": outcome}
    _, info = env.reset()
    report = DockReport.of(info["dock"])
    assert (report.code, report.human, report.attempts, report.recoveries) == (code, True, 2, ("restage",))
    assert len(asked) == 1 and "Put it on its dock" in asked[0]


def test_a_docking_action_that_never_ends_is_cancelled(robot) -> None:
    asked: list[str] = []
    env, body = robot("turtlebot4", person=asked, homing=8.0)
    env.reset(seed=0)
    body._dock = lambda goal: (0.0, 0.0)
    _, info = env.reset()
    docks = [goal.state for goal in body.goals if goal.kind == "dock"]
    assert docks == [GoalState.preempted] * 2 and info["dock"]["code"] == "action_preempted" and asked


def test_a_success_that_left_the_robot_off_its_dock_is_a_failure(robot) -> None:
    asked: list[str] = []
    env, body = robot("turtlebot4", person=asked)
    env.reset(seed=0)
    body.outcome = {"dock": GoalState.succeeded}
    _, info = env.reset()
    assert info["dock"]["human"] and "is not docked" in info["dock"]["text"]


def test_a_robot_that_cannot_leave_its_dock_ends_the_run(robot) -> None:
    env, body = robot("turtlebot4")
    body.outcome = {"undock": GoalState.aborted}
    with pytest.raises(RunFailed, match="did not leave its dock: /undock was aborted"):
        env.reset(seed=0)


def test_a_run_begins_on_the_dock(robot) -> None:
    asked: list[str] = []
    env, body = robot("turtlebot4", person=asked)
    body.docked = False
    env.reset(seed=0)
    assert asked == ["The robot is not on its dock. Put it there."]


def test_a_resumed_run_asks_for_the_robot_to_be_put_back(robot, tmp_path: Path) -> None:
    asked: list[str] = []
    env, _ = robot("turtlebot3", person=asked)
    env.reset(seed=0)
    explore(env)
    env.save(tmp_path)
    again, body = robot("turtlebot3", person=asked)
    again.load(tmp_path)
    _, info = again.reset(seed=0, options={"episode": 4})
    assert info["episode_index"] == 4 and info["dock"]["human"] and len(asked) == 1
    assert isinstance(body, Body) and not again.step(FORWARD)[3]


def test_a_resumed_run_on_the_dock_asks_nobody(robot, tmp_path: Path) -> None:
    asked: list[str] = []
    env, body = robot("turtlebot4", person=asked)
    env.load(tmp_path)
    _, info = env.reset(seed=0)
    assert not asked and info["dock"]["human"] and not body.docked


def test_without_a_terminal_nobody_can_be_asked(monkeypatch) -> None:
    monkeypatch.setattr("sys.stdin.isatty", lambda: False, raising=False)
    with pytest.raises(RunFailed, match=r"Put it on its dock\. Then: curionav resume"):
        ask("Put it on its dock.")
