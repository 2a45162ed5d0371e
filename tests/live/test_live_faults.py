"""Faults of a real robot: its wheels stop within a second, the episode ends and says why, and the next one begins."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from body import Body

from curionav_cli.constants import FORWARD, LEFT
from curionav_cli.errors import RunFailed, Terminated
from curionav_cli.live.env import LiveRobot
from curionav_cli.robot.docking.action import GoalState

STILL_AFTER = 1.2  # seconds: robot.stale and the moment until it is noticed


def until_closed(env: LiveRobot, body: Body, steps: int = 20) -> str:
    """Drive ahead and turn until the episode is closed; returns why."""
    for step in range(steps):
        observation, _, _, truncated, _ = env.step(LEFT if step % 2 else FORWARD)
        assert env.observation_space.contains(observation)
        if truncated:
            assert body.speed == body.rate == 0.0 and not [g for g in body.goals if g.state is GoalState.active]
            return env.events[-1]["why"]
    raise AssertionError("the episode went on")


def stopping_time(body: Body) -> Callable[[], float]:
    """Watch the body from now on: seconds from now until its wheels were last commanded to move."""
    began, moved = body.time, [body.time]
    body.watch.append(lambda: (body.speed or body.rate) and moved.append(body.time))
    return lambda: moved[-1] - began


@pytest.mark.parametrize("profile", ["turtlebot3", "turtlebot4"])
@pytest.mark.parametrize("topic", ["image", "odom", "imu", "scan"])
def test_a_topic_that_falls_silent_stops_the_robot(robot, profile: str, topic: str) -> None:
    env, body = robot(profile)
    env.reset(seed=0)
    env.step(FORWARD)
    body.silent = {topic}
    moved = stopping_time(body)
    why = until_closed(env, body)
    assert moved() <= STILL_AFTER
    assert env.settings.profile.topics()[topic].name in why or "no image newer" in why
    body.silent = set()
    env.reset()
    assert not env.step(FORWARD)[3] and env.events == ()


def test_a_topic_that_falls_silent_in_the_middle_of_a_move(robot) -> None:
    env, body = robot("turtlebot3", max_speed=0.05, move=20.0)
    env.reset(seed=0)
    at = body.time + 1.0
    body.watch.append(lambda: body.time > at and body.silent.add("odom"))
    assert env.step(FORWARD)[3] and body.speed == 0.0 and body.time - at < STILL_AFTER + 0.1
    assert "/odom has been silent for 1" in env.events[-1]["why"]


@pytest.mark.parametrize("profile", ["turtlebot3", "turtlebot4"])
def test_a_lost_connection_closes_the_episode(robot, profile: str) -> None:
    env, body = robot(profile)
    env.reset(seed=0)
    body.link.alive = False
    assert env.step(FORWARD)[3]
    assert env.events == ({"what": "closed", "why": "the connection to the robot is lost"},)
    body.link.alive = True
    body._command({"linear": {"x": 0.0}, "angular": {"z": 0.0}})  # what a base does without commands
    env.reset()
    assert not env.step(LEFT)[3]


def test_a_robot_that_does_not_come_back_ends_the_run_in_a_line(robot) -> None:
    env, body = robot("turtlebot4", patience=3.0)
    env.reset(seed=0)
    body.silent = {"image"}
    until_closed(env, body)
    with pytest.raises(RunFailed) as caught:
        env.reset()
    assert "/oakd/rgb/preview/image_raw/compressed has been silent" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_encoding_that_changes_is_named(robot) -> None:
    env, body = robot("turtlebot4")
    env.reset(seed=0)
    body.depth_encoding = "16UC1"  # as good as 32FC1
    assert not env.step(LEFT)[3]
    body._depth = lambda kind: {"encoding": "yuv422", "height": 1, "width": 1, "step": 2, "data": "AAA="}
    assert "/oakd/stereo/image_raw (sensor_msgs/msg/Image) sent depth with encoding 'yuv422'" in \
        until_closed(env, body)


def test_messages_of_another_type_are_named(robot) -> None:
    env, body = robot("turtlebot3")
    env.reset(seed=0)
    body._imu = lambda kind: {"data": 1.0}
    assert "/imu (sensor_msgs/msg/Imu) sent a message that is no sensor_msgs/Imu" in until_closed(env, body)


def test_a_jump_of_the_odometry_asks_for_a_person(robot) -> None:
    asked: list[str] = []
    env, body = robot("turtlebot3", person=asked)
    env.reset(seed=0)
    env.step(FORWARD)
    body.x += 1.5
    assert "the odometry jumped by 1.5" in until_closed(env, body)
    _, info = env.reset()
    assert len(asked) == 1 and "Put it back to its start" in asked[0]
    assert info["dock"]["human"] and info["dock"]["code"] == "displaced"


def test_a_base_that_starts_anew_asks_for_a_person(robot) -> None:
    asked: list[str] = []
    env, body = robot("turtlebot3", person=asked)
    env.reset(seed=0)
    body.clock_offset = 0.0
    assert "the odometry's clock went back" in until_closed(env, body)
    _, info = env.reset()
    assert len(asked) == 1 and info["dock"]["human"] and not env.step(FORWARD)[3]


@pytest.mark.parametrize("error", [KeyboardInterrupt, Terminated, SystemExit, MemoryError])
@pytest.mark.parametrize("profile", ["turtlebot3", "turtlebot4"])
def test_whatever_ends_the_program_stops_the_wheels(robot, profile: str, error: type[BaseException]) -> None:
    env, body = robot(profile)
    env.reset(seed=0)
    at = body.time + 0.3

    def strike() -> None:
        if body.time > at:
            body.watch.clear()
            raise error

    body.watch.append(strike)
    with pytest.raises(error):
        env.step(FORWARD)
    assert body.speed == body.rate == 0.0
    assert all(goal.state is not GoalState.active for goal in body.goals)


def test_closing_stops_the_wheels_and_the_connection(robot) -> None:
    env, body = robot("turtlebot3")
    env.reset(seed=0)
    body._command({"linear": {"x": 0.2}, "angular": {"z": 0.0}})
    env.close()
    assert body.speed == 0.0 and body.link.closed


def test_the_battery_ends_an_episode_and_is_charged_before_the_next(robot) -> None:
    env, body = robot("turtlebot4")
    env.reset(seed=0)
    body.charge = 0.15
    for _ in range(2):
        truncated = env.step(FORWARD)[3]
    assert truncated and env.events[-1]["why"] == "the battery is down to 15%"
    charging = lambda: setattr(body, "charge", body.charge + (0.0002 if body.docked else 0.0))
    body.watch.append(charging)
    _, info = env.reset()
    assert info["dock"]["code"] == "docked" and info["dock"]["battery"] == pytest.approx(0.15)
    assert body.charge >= 0.6 and not env.step(FORWARD)[3]
