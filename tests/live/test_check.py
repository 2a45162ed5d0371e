"""curionav robot check: what is there, what is missing with the nearest name, and what to mend."""

from __future__ import annotations

import math

import pytest

from curionav_cli.live.check import ABSENT, BAD, LEFT_OUT, OK, SILENT, UNKNOWN, WRONG, Finding, findings
from curionav_cli.live.env import LiveRobot


def checked(env: LiveRobot, move: bool = False) -> dict[str, Finding]:
    return {one.what: one for one in findings(env.base, move)}


@pytest.mark.parametrize("profile", ["turtlebot2i", "turtlebot3"])
def test_a_good_robot_has_nothing_to_mend(robot, profile: str) -> None:
    env, body = robot(profile)
    body.docked, body.yaw = False, 0.0
    found = checked(env, move=True)
    assert not [one for one in found.values() if one.state in BAD]
    assert "10.0 a second" in found["image"].about
    assert found["move ahead"].state == OK and found["turn left"].about.endswith("with its image")
    assert 0.2 < body.x - 1.0 < 0.3 and abs(math.degrees(body.yaw)) < 1.0


def test_a_camera_that_is_off_on_the_dock_is_not_a_mistake(robot) -> None:
    env, body = robot("turtlebot4")
    found = checked(env)
    assert found["image"].state == UNKNOWN and "docked" in found["image"].about
    assert found["content docked"].about == "yes" and found["action undock"].state == OK
    assert not body.goals and not [one for one in found.values() if one.state in BAD]


def test_a_missing_topic_has_its_nearest_name(robot) -> None:
    env, body = robot("turtlebot3")
    del body.link.offered["/camera/image_raw/compressed"]
    body.link.offered["/camera/image/compressed"] = "sensor_msgs/msg/CompressedImage"
    found = checked(env)
    assert found["image"].state == ABSENT and "/camera/image/compressed" in found["image"].about
    assert found["image"].cure == "robot.profile.image.name=/camera/image/compressed"


def test_another_type_is_named_with_its_cure(robot) -> None:
    env, body = robot("turtlebot3")
    body.link.offered["/scan"] = "sensor_msgs/msg/PointCloud2"
    body.link.offered["/cmd_vel"] = "std_msgs/msg/String"
    found = checked(env)
    assert found["scan"].state == found["velocity"].state == WRONG
    assert found["scan"].cure == "robot.profile.scan.type=sensor_msgs/msg/PointCloud2"


def test_a_silent_topic_and_a_message_that_cannot_be_used(robot) -> None:
    env, body = robot("turtlebot3")
    body.silent = {"imu"}
    body._scan = lambda kind: {"ranges": "none"}
    found = checked(env)
    assert found["imu"].state == SILENT and found["content scan"].state == WRONG


def test_a_bridge_that_cannot_list_its_topics(robot) -> None:
    env, body = robot("turtlebot4")
    body.link.told = False
    found = checked(env)
    assert found["rosapi"].state == found["velocity"].state == found["action dock"].state == UNKNOWN
    assert not [one for one in found.values() if one.state in BAD]


def test_a_missing_action_has_its_nearest_name(robot) -> None:
    env, body = robot("turtlebot4")
    body.link.servers["/drive_distances"] = body.link.servers.pop("/drive_distance")
    assert checked(env)["action drive"].cure == "robot.profile.drive.name=/drive_distances"


def test_wheels_that_do_not_turn_are_found(robot) -> None:
    env, body = robot("turtlebot3")
    body.stiff = True
    assert checked(env, move=True)["move ahead"].state == WRONG and body.speed == 0.0


def test_nothing_moves_towards_a_wall(robot) -> None:
    env, body = robot("turtlebot3")
    body.x = 5.6
    assert checked(env, move=True)["move ahead"].state == LEFT_OUT and body.x == 5.6
