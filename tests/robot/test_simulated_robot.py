"""The true robot: commands, motion, measurements."""

from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.constants import STEP_LENGTH
from curionav_cli.geometry import wrapped
from curionav_cli.robot.simulated_robot import SimulatedRobot


def a_body(profile, scene, seed=0):
    body = SimulatedRobot(profile, np.random.default_rng(seed))
    body.place(scene, scene.plan.start)
    return body


def test_without_noise_motion_and_measurements_are_the_command(quiet, large_lab):
    body = a_body(quiet, large_lab)
    x, y, yaw = body.pose
    reading = body.drive(0.25, 0.0, 0.6)
    assert body.pose == pytest.approx((x + 0.25, y, yaw))
    assert reading.wheel == pytest.approx(0.25) and reading.gyro == 0.0
    reading = body.drive(0.0, np.radians(10), 0.6)
    assert body.pose.yaw == pytest.approx(np.radians(10)) and reading.gyro == pytest.approx(np.radians(10))
    assert reading.time == body.time == pytest.approx(1.2) and body.battery.left == pytest.approx(900 - 1.2)


def test_motion_and_sensors_have_the_noise_of_the_profile(turtlebot, large_lab):
    """400 robots, one metre ahead each, in tenths; then 30 s of rest."""
    drive = replace(turtlebot, drive=replace(turtlebot.drive, veer=0.0))
    driven, wheels, gyros = [], [], []
    for seed in range(400):
        body = a_body(drive, large_lab, seed)
        start = body.pose
        wheels.append(sum(body.drive(0.1, 0.0, 0.2).wheel for _ in range(10)))
        driven.append(body.pose.x - start.x)
        gyros.append(sum(body.drive(0.0, 0.0, 0.6).gyro for _ in range(50)))
    off = np.array(wheels) - driven
    odometry, gyro = turtlebot.odometry, turtlebot.gyro
    assert np.std(driven) == pytest.approx(turtlebot.drive.forward, rel=0.12)
    assert np.std(off) == pytest.approx(np.hypot(odometry.scale, odometry.noise), rel=0.12)
    assert np.degrees(np.std(gyros)) == pytest.approx(np.hypot(gyro.noise * np.sqrt(30), gyro.bias * 30), rel=0.12)


def test_contact_stops_the_robot_while_its_wheels_turn_on(turtlebot, small_room):
    slipped, twists = [], []
    for seed in range(60):
        body = a_body(turtlebot, small_room, seed)
        while (reading := body.drive(STEP_LENGTH, 0.0, 0.6)).bump is None:
            before = body.pose
        free = np.hypot(body.pose.x - before.x, body.pose.y - before.y)
        if free < 0.8 * STEP_LENGTH:
            slipped.append((reading.wheel - free) / (STEP_LENGTH - free))
        twists.append(np.degrees(wrapped(body.pose.yaw - before.yaw)))
        assert reading.bump in ("left", "centre", "right")
    assert np.median(slipped) == pytest.approx(0.65, abs=0.1) and min(slipped) > 0.1
    assert 1.0 < np.std(twists) < 5.0


def test_driving_back_against_a_wall_presses_no_bumper(quiet, small_room):
    body = a_body(quiet, small_room)
    readings = [body.drive(-0.1, 0.0, 0.3) for _ in range(8)]
    assert all(one.bump is None for one in readings) and body.pose.y >= small_room.plan.radius


def test_a_scan_shows_the_walls_and_not_what_is_too_near(quiet, small_room):
    body = a_body(quiet, small_room)
    scan = body.scan()
    ahead, back = np.abs(scan.bearing).argmin(), np.abs(scan.bearing + np.pi).argmin()
    assert scan.range[back] == pytest.approx(0.45) and scan.range[ahead] > 3.0
    body.pose = body.pose._replace(y=0.1)
    assert np.isnan(body.scan().range[back]), "nearer than the LiDAR's blind zone"


@pytest.mark.parametrize("sensor", ["wheel", "gyro", "bumper", "lidar", "depth"])
def test_a_silent_sensor_says_nothing(turtlebot, small_room, sensor):
    body = a_body(turtlebot, small_room)
    body.silent.add(sensor)
    readings = [body.drive(STEP_LENGTH, 0.0, 0.6) for _ in range(20)]
    said = {"wheel": np.isfinite(readings[0].wheel), "gyro": np.isfinite(readings[0].gyro),
            "bumper": any(one.bump for one in readings), "lidar": np.isfinite(body.scan().range).any(),
            "depth": np.isfinite(body.depth().range).any()}
    body.pose = body.pose._replace(yaw=body.pose.yaw + np.pi)
    said["depth"] = said["depth"] or bool(np.isfinite(body.depth().range).any())
    assert said == {name: name != sensor for name in said}


def test_zero_velocity_after_halt(quiet, large_lab):
    body = a_body(quiet, large_lab)
    body.drive(0.05, 0.1, 0.1)
    assert body.velocity == pytest.approx((0.5, 1.0))
    body.halt()
    assert body.velocity == (0.0, 0.0)


def test_the_same_seed_gives_the_same_life_and_what_is_saved_goes_on(turtlebot, large_lab):
    one, two, other = a_body(turtlebot, large_lab), a_body(turtlebot, large_lab), a_body(turtlebot, large_lab, 1)
    for body in (one, two, other):
        for _ in range(5):
            body.drive(0.25, 0.0, 0.6)
            body.scan()
    assert one.save() == two.save() != other.save()
    other.load(one.save())
    assert one.drive(0.25, 0.1, 0.6) == other.drive(0.25, 0.1, 0.6) and one.pose == other.pose
    assert np.array_equal(one.scan().range, other.scan().range, equal_nan=True)
