"""The dock's light, its contacts and the alignment drive, by geometry alone."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.records import Pose
from curionav_cli.robot.charging_dock import ChargingDock
from curionav_cli.robot.docking.approach import Approach, State
from curionav_cli.robot.docking_settings import Approach as Speeds
from curionav_cli.robot.docking_settings import Contact, InfraredLight
from curionav_cli.robot.infrared import CENTRE, LEFT, NEAR, RIGHT, Infrared, sectors

LIGHT = InfraredLight(range=3.0, near=0.5, cone=22.0, centre_sector=6.0, overlap=2.0, centre_width=14.0,
                      side_axis=55.0, side_width=40.0, missed=0.0)
SPEEDS = Speeds(scan=0.66, crawl=0.1, find=0.33, stream=0.05, far=0.1, far_turn=0.3, near=0.05, near_turn=0.1, stuck=15)
STATION = ChargingDock(Pose(2.0, 1.0, math.pi / 2), 0.18, Contact(0.04, 15.0))
FACING = -math.pi / 2  # the yaw of a robot that looks at this station


def infrared(light: InfraredLight = LIGHT, sight: bool = True) -> Infrared:
    return Infrared(light, STATION, np.random.default_rng(0), lambda *line: sight)


def test_sectors_are_seen_from_the_dock() -> None:
    assert sectors(LIGHT, 1.0, 0.0) == CENTRE & ~NEAR
    assert sectors(LIGHT, 0.4, 0.0) == CENTRE & NEAR
    assert sectors(LIGHT, 1.0, math.radians(15)) == LEFT & ~NEAR
    assert sectors(LIGHT, 1.0, math.radians(-15)) == RIGHT & ~NEAR
    assert sectors(LIGHT, 1.0, math.radians(7)) == (LEFT | CENTRE) & ~NEAR
    assert sectors(LIGHT, 1.0, math.radians(23)) == 0
    assert sectors(LIGHT, 3.1, 0.0) == 0


def test_the_dock_s_left_is_on_the_right_of_who_looks_at_it() -> None:
    """The station looks along +y: its left is -x."""
    assert infrared().frame(Pose(1.75, 2.0, FACING))[1] & LEFT
    assert infrared().frame(Pose(2.25, 2.0, FACING))[1] & RIGHT


def test_each_receiver_looks_its_way() -> None:
    right, centre, left = infrared().frame(Pose(2.0, 2.0, FACING))
    assert centre and not right and not left
    right, centre, left = infrared().frame(Pose(2.0, 2.0, FACING + math.radians(55)))  # the dock on its right
    assert right and not centre and not left
    right, centre, left = infrared().frame(Pose(2.0, 2.0, FACING - math.radians(55)))
    assert left and not centre and not right
    assert infrared().frame(Pose(2.0, 2.0, -FACING)) == (0, 0, 0)


def test_what_is_in_between_hides_the_dock() -> None:
    assert infrared(sight=False).frame(Pose(2.0, 2.0, FACING)) == (0, 0, 0)


def test_frames_are_missed_at_the_given_rate_and_remembered_for_four() -> None:
    light = infrared(replace(LIGHT, missed=0.5))
    frames = [light.frame(Pose(2.0, 2.0, FACING))[1] for _ in range(2000)]
    assert sum(map(bool, frames)) == pytest.approx(1000, abs=5 * math.sqrt(500))
    light = infrared()
    assert light.receive(Pose(2.0, 2.0, FACING))[1]
    gone = [light.receive(Pose(2.0, 2.0, -FACING))[1] for _ in range(4)]
    assert [bool(bits) for bits in gone] == [True, True, True, False]


@pytest.mark.parametrize(("across", "turned", "flows"), [
    (0.0, 0.0, True), (0.03, 0.0, True), (-0.03, 10.0, True), (0.05, 0.0, False),
    (0.0, 20.0, False), (0.0, 180.0, False),
])
def test_current_flows_where_contacts_meet(across: float, turned: float, flows: bool) -> None:
    pose = Pose(2.0 + across, 1.0 - 1e-6, FACING + math.radians(turned))
    assert STATION.touched(pose)
    assert STATION.charging(pose) is flows


def test_nothing_is_touched_from_afar_nor_beside() -> None:
    assert not STATION.touched(Pose(2.0, 1.02, FACING))
    assert not STATION.touched(Pose(2.4, 0.8, FACING))
    assert STATION.touched(Pose(2.2, 0.8, FACING)) and not STATION.charging(Pose(2.2, 0.8, FACING))
    assert STATION.relative(Pose(2.0, 2.5, FACING)) == pytest.approx((1.5, 0.0, 0.0))


def approached(pose: Pose, seconds: float = 200.0) -> tuple[Pose, list[State]]:
    """A robot without noise that obeys the drive until current flows; where it ends, what it did."""
    drive, light, states, turned = Approach(SPEEDS), infrared(), [], 0.0
    for _ in range(round(seconds / 0.1)):
        speed, turn = drive.tick(light.receive(pose), turned)
        turned = 0.1 * turn
        yaw = pose.yaw + 0.5 * turned
        pose = Pose(pose.x + 0.1 * speed * math.cos(yaw), pose.y + 0.1 * speed * math.sin(yaw), pose.yaw + turned)
        states += [drive.state] if states[-1:] != [drive.state] else []
        if STATION.charging(pose):
            break
        if STATION.touched(pose) and drive.state is not State.bumped:
            drive.bump()
    return pose, states


@pytest.mark.parametrize("turned", [-170, -90, 0, 60, 120])
def test_from_the_axis_it_finds_the_contacts_whatever_way_it_looks(turned: float) -> None:
    pose, states = approached(Pose(2.0, 2.0, FACING + math.radians(turned)))
    assert STATION.charging(pose)
    assert states[-1] is State.aligned_near


@pytest.mark.parametrize("aside", [-0.3, 0.3])
def test_from_a_side_sector_it_crosses_to_the_middle(aside: float) -> None:
    pose, states = approached(Pose(2.0 + aside, 2.0, FACING))
    assert STATION.charging(pose) and State.find_stream in states and State.get_stream in states


def test_outside_of_the_light_it_turns_for_ever() -> None:
    pose, states = approached(Pose(3.5, 2.0, FACING))
    assert states == [State.scan] and (pose.x, pose.y) == (3.5, 2.0)


def test_after_a_bump_it_backs_off_and_scans() -> None:
    drive = Approach(SPEEDS)
    drive.bump()
    speeds = [drive.tick((0, 0, 0), 0.0) for _ in range(12)]
    assert all(speed < 0 and turn == 0 for speed, turn in speeds[:10])
    assert drive.state is State.scan and speeds[-1] == (0.0, SPEEDS.scan)
