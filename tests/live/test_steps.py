"""A step of a real robot: moves, what cancels them, and the image that belongs to it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.constants import FORWARD, LEFT, RIGHT
from curionav_cli.live.settings import Twist

PROFILES = ("turtlebot2i", "turtlebot3", "turtlebot4")


@pytest.mark.parametrize("profile", PROFILES)
def test_moves_are_the_agents_own(robot, profile: str) -> None:
    env, body = robot(profile)
    env.reset(seed=0)
    x, yaw = body.x, body.yaw
    _, reward, terminated, truncated, info = env.step(FORWARD)
    assert body.x - x == pytest.approx(0.25, abs=0.015)
    assert (reward, terminated, truncated, bool(info["collided"])) == (0.0, False, False, False)
    env.step(LEFT)
    assert math.degrees(body.yaw - yaw) == pytest.approx(10.0, abs=0.7)
    env.step(RIGHT)
    env.step(RIGHT)
    assert math.degrees(body.yaw - yaw) == pytest.approx(-10.0, abs=1.0)


@pytest.mark.parametrize("profile", PROFILES)
def test_the_estimate_follows_the_robot_in_the_frame_of_its_dock(robot, profile: str) -> None:
    env, body = robot(profile)
    env.reset(seed=0)
    for action in (FORWARD, LEFT, LEFT, LEFT, FORWARD, RIGHT, FORWARD):
        *_, info = env.step(action)
    start = env.floor.plan.start
    found = info["estimate"] - (start.x, start.y, start.yaw)
    np.testing.assert_allclose(found, (body.x - 1.0, body.y - 2.0, body.yaw), atol=0.02)
    np.testing.assert_array_equal(info["pose"], info["estimate"])


@pytest.mark.parametrize("profile", PROFILES)
def test_an_image_is_of_the_place_where_the_step_ended(robot, profile: str) -> None:
    env, body = robot(profile)
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation)
    for action in (FORWARD, LEFT, FORWARD, RIGHT):
        observation, *_ = env.step(action)
        assert np.abs(observation["image"].astype(int) - body.colour).max() <= 1 + 5 * (profile == "turtlebot2i")


def test_an_image_that_was_overtaken_is_not_used(robot) -> None:
    env, body = robot("turtlebot3")
    env.reset(seed=0)
    body.watch.append(lambda: body.ticks % 5 == 1 and body.publish("image", ago=30.0))
    observation, *_ = env.step(FORWARD)
    assert np.abs(observation["image"].astype(int) - body.colour).max() <= 1


def test_depth_cancels_a_move_into_a_wall(robot) -> None:
    env, body = robot("turtlebot4")
    env.reset(seed=0)
    moves = [env.step(FORWARD)[4]["collided"] for _ in range(24)]
    assert moves[0] == False and moves[-1] == True  # noqa: E712  numpy's
    stood = body.x
    env.step(FORWARD)
    assert body.x == stood and body.x + 0.18 < 6.0
    assert not any(goal.kind == "drive" for goal in body.goals[-1:] if goal.left)


@pytest.mark.parametrize("profile", PROFILES)
def test_a_bumper_stops_a_move_and_counts_as_collided(robot, profile: str) -> None:
    env, body = robot(profile)
    env.reset(seed=0)
    body.obstacle = body.x + 0.18 + 0.1
    *_, truncated, info = env.step(FORWARD)
    assert info["collided"] and not truncated
    assert body.speed == 0.0
    body.obstacle = math.inf
    body.touch(False)
    assert not env.step(LEFT)[4]["collided"]


@pytest.mark.parametrize("profile", ["turtlebot2i", "turtlebot4"])
def test_a_wheel_that_hangs_ends_a_turn_too(robot, profile: str) -> None:
    env, body = robot(profile)
    env.reset(seed=0)
    yaw = body.yaw
    body.watch.append(lambda: abs(body.yaw - yaw) > math.radians(2.0) and body.lift(True))
    env.step(LEFT)
    assert 0.0 < math.degrees(body.yaw - yaw) < 6.0 and body.speed == 0.0
    body.watch.pop()
    body.lift(False)
    stood = body.yaw
    env.step(RIGHT)
    assert math.degrees(stood - body.yaw) == pytest.approx(10.0, abs=0.7)


def test_wheels_that_do_not_turn_end_a_move_by_its_limit(robot) -> None:
    env, body = robot("turtlebot3")
    env.reset(seed=0)
    body.stiff, began = True, body.time
    *_, info = env.step(FORWARD)
    assert info["collided"] and 2.4 < body.time - began < 4.0 and body.speed == 0.0


def test_the_geofence_holds_the_robot_back_and_lets_it_return(robot) -> None:
    env, body = robot("turtlebot3", geofence=0.6)
    env.reset(seed=0)
    for _ in range(5):
        *_, info = env.step(FORWARD)
    assert info["collided"] and math.hypot(body.x - 1.0, body.y - 2.0) <= 0.61
    assert [event["what"] for event in env.events] == ["geofence"]
    for _ in range(18):
        env.step(LEFT)
    assert not env.step(FORWARD)[4]["collided"]


def test_no_command_is_faster_than_was_set(robot) -> None:
    env, body = robot("turtlebot3", max_speed=0.1, max_turn=20.0, move=10.0)
    env.reset(seed=0)
    for action in (FORWARD, LEFT):
        env.step(action)
    sent = [message["twist"] for message in body.link.heard["/cmd_vel"]]
    assert max(abs(one["linear"]["x"]) for one in sent) == pytest.approx(0.1)
    assert max(abs(one["angular"]["z"]) for one in sent) <= math.radians(20.0) + 1e-9


@pytest.mark.parametrize(("twist", "told", "stamped"), [
    (Twist.auto, "geometry_msgs/msg/Twist", False), (Twist.auto, "geometry_msgs/msg/TwistStamped", True),
    (Twist.plain, "geometry_msgs/msg/TwistStamped", False), (Twist.stamped, "geometry_msgs/msg/Twist", True),
])
def test_velocity_commands_have_the_type_of_the_robot(robot, twist: Twist, told: str, stamped: bool) -> None:
    profile = robot("turtlebot3")[0].settings.profile
    profile = replace(profile, velocity=replace(profile.velocity, type=told))
    env, body = robot("turtlebot3", twist=twist, profile=profile)
    env.reset(seed=0)
    env.step(FORWARD)
    assert ("twist" in body.link.heard["/cmd_vel"][0]) == stamped
    assert body.link.advertised["/cmd_vel"].endswith("TwistStamped") == stamped


def test_a_namespace_stands_before_every_name(robot) -> None:
    env, body = robot("turtlebot4", namespace="/robot7/")
    env.reset(seed=0)
    env.step(FORWARD)
    names = {*body.link.subscribers, *body.link.advertised}
    assert names and all(name.startswith("/robot7/") for name in names)


def test_a_dry_run_sends_nothing(robot, capsys) -> None:
    from curionav_cli.live.dry_run import DryRun
    from curionav_cli.live.env import LiveRobot

    plain, body = robot("turtlebot3", dry_run=True)
    env = LiveRobot(plain.floor, plain.settings, DryRun(body.link, print), body, lambda what: None)
    env.reset(seed=0)
    x = body.x
    env.step(FORWARD)
    env.reset()
    env.close()
    assert body.x == x and not body.link.heard and "would send /cmd_vel {'twist': {'linear': {'x': 0.2" in \
        capsys.readouterr().out


def test_it_is_a_gymnasium_environment(robot) -> None:
    env, _ = robot("turtlebot4")
    env.reset(seed=0)
    assert env.action_space.n == 3
    for action in range(3):
        observation, reward, _, _, info = env.step(action)
        assert env.observation_space.contains(observation) and isinstance(reward, float)
        assert set(info) == {"pose", "collided", "episode_index", "estimate"}
    with pytest.raises(ValueError, match="action 3 is none of"):
        env.step(3)
