"""Our worlds as a robot for others: what a client drives over topics and actions is what the simulation drives."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from office import write_two_rooms
from worlds import Client, World, apart, placed

from curionav_cli.constants import FORWARD, STEP_LENGTH, Stream
from curionav_cli.live.contacts import charge, docked
from curionav_cli.live.served.body import TICK
from curionav_cli.robot.docking.action import GoalState
from curionav_cli.robot.simulated_robot import SimulatedRobot

MOVES = 100


def test_a_client_drives_a_hundred_moves_by_velocity_as_the_simulation_does() -> None:
    """With drift: the same seed gives the same slips, so that the poses are the same to the bit."""
    world = World("robot.profile=turtlebot3", "env=small_room", "seed=3")
    client, body = Client(world, "/odom", "/ground_truth"), world.robot.body
    alone = SimulatedRobot(world.settings.robot, np.random.default_rng([3, Stream.robot]))
    alone.place(body.scene, body.scene.plan.start)
    draws, touched = np.random.default_rng(0), 0
    for _ in range(MOVES):
        speed, rate = (0.25, 0.0) if draws.random() < 0.6 else (0.0, draws.choice([-0.8, 0.8]))
        for _ in range(3):
            client.command(speed, rate, 0.2)
            touched += sum(alone.drive(speed * TICK, rate * TICK, TICK).bump is not None for _ in range(10))
        assert world.pose == alone.pose
    assert apart(client.pose("/ground_truth"), alone.pose) < 1e-12 and touched > 3
    assert apart(placed(client.pose("/odom"), body.scene.plan.start), alone.pose) > 1e-3  # it drifts


def test_a_client_drives_a_hundred_moves_by_actions_as_the_simulation_does() -> None:
    world = World("robot.profile=turtlebot4", "env=small_room", exact=True)
    client, body = Client(world, "/odom", "/ground_truth"), world.robot.body
    assert client.act("/undock") is GoalState.succeeded
    start, alone = world.pose, SimulatedRobot(body.profile, np.random.default_rng(0), body.body.station)
    alone.place(body.scene, start)
    world.sleep(0.1)
    began, draws, aborted = client.pose("/odom"), np.random.default_rng(0), 0
    for _ in range(MOVES):
        if draws.random() < 0.6:
            free = alone.drive(STEP_LENGTH, 0.0, 0.6).bump is None
            state = client.act("/drive_distance", distance=STEP_LENGTH)
            aborted += not free
            assert state is (GoalState.succeeded if free else GoalState.aborted)
        else:
            angle = math.radians(draws.choice([-10.0, 10.0]))
            alone.drive(0.0, angle, 0.6)
            assert client.act("/rotate_angle", angle=angle, max_rotation_speed=0.5) is GoalState.succeeded
        assert apart(world.pose, alone.pose) < 1e-9
    world.sleep(0.1)
    assert aborted > 3 and apart(client.pose("/ground_truth"), alone.pose) < 1e-9
    moved = placed(client.pose("/odom"), began._replace(x=0.0, y=0.0, yaw=start.yaw - began.yaw))
    first = placed(began, began._replace(x=0.0, y=0.0, yaw=start.yaw - began.yaw))
    slipped = 0.3 * STEP_LENGTH * aborted  # wheels turn on against a wall
    assert math.hypot(moved.x - first.x + start.x - alone.pose.x, moved.y - first.y + start.y - alone.pose.y) <= slipped


@pytest.mark.parametrize("twist", ["stamped", "plain"])
def test_velocity_commands_have_the_type_that_was_set(twist: str) -> None:
    world = World("robot.profile=turtlebot3", f"robot.twist={twist}")
    kind = world.memory.offered["/cmd_vel"]
    assert kind == f"geometry_msgs/msg/Twist{'Stamped' * (twist == 'stamped')}"
    plain = {"linear": {"x": 0.2}, "angular": {"z": 0.0}}
    Client(world)
    before = world.pose
    world.memory.publish("/cmd_vel", {"twist": plain} if twist == "stamped" else plain)
    world.sleep(0.4)
    assert math.hypot(world.pose.x - before.x, world.pose.y - before.y) == pytest.approx(0.08, abs=0.02)


def test_the_wheels_stop_without_commands_and_a_broken_one_is_named_once() -> None:
    world = World("robot.profile=turtlebot3", exact=True)
    client = Client(world)
    before = world.pose
    client.command(0.2, 0.0, 3.0)
    assert math.hypot(world.pose.x - before.x, world.pose.y - before.y) == pytest.approx(0.1, abs=0.005)
    for message in ({"linear": 1}, {"linear": 1}, {"linear": {"x": math.nan}, "angular": {"z": 0.0}}):
        world.memory.publish("/cmd_vel", message)
    assert len(world.said) == 2 and "geometry_msgs/Twist" in world.said[0] and "not finite" in world.said[1]


def test_a_new_goal_ends_the_one_before_and_a_cancel_stops() -> None:
    world = World("robot.profile=turtlebot4", exact=True)
    client = Client(world)
    client.act("/undock")
    first = world.memory.action("/drive_distance", "", {"distance": 1.0})
    world.sleep(0.5)
    second = world.memory.action("/rotate_angle", "", {"angle": 1.0})
    world.sleep(0.1)
    assert first.state is GoalState.preempted and second.state is GoalState.active
    client.command(0.3, 0.0, 0.02)  # not obeyed while a goal is carried out
    at = world.pose
    second.cancel()
    world.sleep(0.1)
    assert second.state is GoalState.preempted and world.robot.goal is None
    world.sleep(0.6)
    still = world.pose
    world.sleep(0.5)
    assert still == world.pose and math.hypot(still.x - at.x, still.y - at.y) < 0.17


def test_a_cancel_during_a_motion_ends_the_goal_after_it() -> None:
    """A cancel comes from another thread, at any moment of the robot's."""
    world = World("robot.profile=turtlebot4", exact=True)
    goal = world.memory.action("/undock", "", {})
    world.robot.body.after = goal.cancel
    world.robot.step()
    assert goal.state is GoalState.preempting and world.robot.goal is goal
    world.robot.step()
    assert goal.state is GoalState.preempted and world.robot.goal is None


def test_docking_by_light_succeeds_is_aborted_and_is_cancelled() -> None:
    world = World("robot.profile=turtlebot4", "env=small_room", exact=True)
    client = Client(world, "/dock_status")
    assert client.act("/undock") is GoalState.succeeded and client.act("/undock") is GoalState.aborted
    client.act("/drive_distance", distance=0.3)
    client.act("/rotate_angle", angle=math.pi)
    going = world.memory.action("/dock", "", {})
    world.sleep(2.0)
    going.cancel()
    world.sleep(0.2)
    assert going.state is GoalState.preempted
    assert client.act("/dock") is GoalState.succeeded
    world.sleep(1.0)
    assert docked(client.heard["/dock_status"][-1], "DockStatus") and world.robot.body.charging
    assert client.act("/dock") is GoalState.succeeded  # it is there already
    client.act("/undock")
    client.act("/drive_distance", distance=2.0)
    client.act("/rotate_angle", angle=1.5)
    away = world.memory.action("/dock", "", {})
    while away.state is GoalState.active:
        world.sleep(0.1)
    assert away.state is GoalState.aborted and away.text and not world.robot.body.charging


def test_a_docked_turtlebot4_is_dark_and_a_person_may_carry_it_back() -> None:
    world = World("robot.profile=turtlebot4", images=10.0)
    client = Client(world, "/scan", "/odom", "/oakd/rgb/preview/image_raw/compressed", "/oakd/stereo/image_raw")
    world.sleep(1.0)
    assert client.heard["/odom"] and not client.heard["/scan"]
    assert not client.heard["/oakd/rgb/preview/image_raw/compressed"] and not client.heard["/oakd/stereo/image_raw"]
    client.act("/undock")
    world.sleep(1.0)
    assert len(client.heard["/scan"]) >= 10 and len(client.heard["/oakd/stereo/image_raw"]) >= 10
    began = client.pose("/odom")
    world.memory.publish("/put_back", {})
    world.sleep(0.1)
    assert world.robot.body.charging and apart(client.pose("/odom"), began) < 0.02  # its wheels have not turned


def test_the_battery_empties_off_the_dock_and_fills_on_it() -> None:
    world = World("robot.profile=turtlebot4", "robot.battery.capacity=20", "robot.battery.reserve=5", recharge=4.0)
    client = Client(world, "/battery_state")
    client.act("/undock")
    world.sleep(20.0)
    assert charge(client.heard["/battery_state"][-1], "BatteryState") == 0.0
    before = world.pose
    client.command(0.0, 0.5, 0.4)
    assert world.pose == before
    world.memory.publish("/put_back", {})
    world.sleep(5.0)
    assert charge(client.heard["/battery_state"][-1], "BatteryState") == pytest.approx(1.0, abs=0.01)


def test_a_ros_map_is_served_as_a_scene_is(tmp_path: Path) -> None:
    world = World("robot.profile=turtlebot3", "env=map", f"env.map={write_two_rooms(tmp_path)}", exact=True)
    client, start = Client(world, "/scan", "/odom"), world.pose
    client.command(0.0, 0.8, 0.4)
    assert apart(placed(client.pose("/odom"), start), world.pose) < 0.02
    ranges = np.array(client.heard["/scan"][-1]["ranges"])
    assert 0.2 < ranges.min() < 3.0 and ranges.max() <= client.heard["/scan"][-1]["range_max"] + 1.0


def test_frames_lead_from_odometry_to_scanner_and_camera() -> None:
    world = World("robot.profile=turtlebot4")
    client = Client(world, "/tf", "/odom")
    world.sleep(0.2)
    base, scanner, camera = client.heard["/tf"][-1]["transforms"]
    assert (base["header"]["frame_id"], base["child_frame_id"]) == ("odom", "base_link")
    assert 2 * math.asin(scanner["transform"]["rotation"]["z"]) == pytest.approx(math.radians(90.0))
    assert camera["transform"]["translation"]["z"] == 0.25


@pytest.mark.parametrize("profile", ["turtlebot3", "turtlebot4"])
def test_a_wall_presses_the_bumper(profile: str) -> None:
    world = World(f"robot.profile={profile}", "env=small_room", exact=True, images=10.0)
    env = world.explorer()
    env.reset(seed=0)
    env.base.depth = lambda: env.base.sensors.around()._replace(range=np.full(180, np.nan))  # it sees nothing
    env._forward = lambda: env.base.mover.forward(STEP_LENGTH, env.base.pause) or bool(env.base.sensors.bumped())
    collided = [bool(env.step(FORWARD)[4]["collided"]) for _ in range(16)]
    assert not collided[0] and collided[-1] and world.robot.body.reading.bump is None  # it does not push on


def test_the_odometry_of_an_exact_robot_is_its_pose() -> None:
    world = World("robot.profile=turtlebot3", "env=small_room", exact=True)
    client, start = Client(world, "/odom"), world.pose
    for speed, rate in ((0.2, 0.0), (0.1, 0.5), (0.0, -0.8), (-0.1, 0.3)):
        client.command(speed, rate, 0.4)
    world.sleep(0.2)
    assert apart(placed(client.pose("/odom"), start), world.pose) < 1e-9
