"""Bags of other recorders: every format gives the same episodes, and what cannot be used is counted."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drives import ODOM, STARTED, Drive, mcap, ros1, ros2, taken
from rosbags.rosbag2 import StoragePlugin

from curionav_cli.bags import sandbox, source
from curionav_cli.bags.intake import UNUSABLE
from curionav_cli.bags.source import Source
from curionav_cli.config.compose import composed
from curionav_cli.errors import BagError
from curionav_cli.records import Episode

DEPTH = "/oakd/stereo/image_raw"  # of turtlebot4
LEGS = [(0.5, 0.0, 0.0), (5.0, 0.2, 0.0), (1.0, 0.0, math.radians(-45)), (5.0, 0.2, math.radians(5)), (1.0, 0.0, 0.0)]


def assert_equal(found: list[Episode], expected: list[Episode]) -> None:
    assert len(found) == len(expected) > 0
    for one, other in zip(found, expected):
        for key in ("image", "action", "pose", "collided"):
            np.testing.assert_array_equal(getattr(one, key), getattr(other, key))


def test_images_are_of_the_poses(read) -> None:
    drive = Drive(LEGS)
    (episode,), report = read(drive)
    assert report["profile"] == "turtlebot3" and not report["left_out"]
    assert report["moves"] == np.bincount(episode.action).tolist() and report["moves"][0] == 8
    assert episode.image.shape == (len(episode) + 1, 64, 64, 3) and not episode.collided.any()
    for image, pose in zip(episode.image, episode.pose):
        true = drive.pose(taken(image))
        np.testing.assert_allclose(pose, [true["x"], true["y"], true["yaw"]], atol=1e-9)


@pytest.mark.parametrize("made", [
    lambda path, drive: ros1(path.with_suffix(".bag"), drive),
    lambda path, drive: ros2(path, drive, StoragePlugin.SQLITE3),
    lambda path, drive: ros2(path, drive, StoragePlugin.SQLITE3) / "bag.db3",
    lambda path, drive: ros2(path, drive),
], ids=["ros1", "sqlite folder", "db3", "mcap folder"])
def test_every_format_gives_the_same(tmp_path: Path, read, made: Callable[[Path, Drive], Path]) -> None:
    drive = Drive(LEGS)
    assert_equal(read(made(tmp_path / "bag", drive))[0], read(drive)[0])


@pytest.mark.parametrize("drive", [
    Drive(LEGS, raw=True, image="/camera/image_raw"),
    Drive(LEGS, image="/oakd/rgb/preview/image_raw/compressed"),
    Drive(LEGS, image="/camera/color/image_raw/compressed"),
], ids=["turtlebot3 uncompressed", "turtlebot4", "turtlebot2i"])
def test_topics_are_those_of_the_profiles(read, drive: Drive) -> None:
    assert_equal(read(drive)[0], read(Drive(LEGS))[0])


def without(depth: Callable[[float], bool]) -> Callable[[str, int, dict[str, Any]], dict[str, Any] | None]:
    """Leave out the depth images of some seconds."""
    return lambda topic, number, fields: None if topic == DEPTH and depth(fields["stamp"] - STARTED) else fields


def test_depth_is_that_of_a_fifth_of_a_second_at_most_before_the_image(read) -> None:
    drive = Drive(LEGS, image="/oakd/rgb/preview/image_raw/compressed", depth=DEPTH)
    (episode,), report = read(drive)
    late = np.array([taken(image) for image in episode.image]) - 10.0 * (episode.depth[:, 20, 20] - 1.0)
    assert episode.depth.shape == (len(episode) + 1, 64, 64) and late.min() > -1e-3 and late.max() < 0.11
    assert not report["left_out"] and np.ptp(episode.depth, axis=(1, 2)).max() == 0.0
    (gap,), _ = read(replace(drive, sent=[], change=without(lambda at: 3.0 < at < 4.5)))
    assert gap.depth is None and len(gap) == len(episode)


def test_other_encodings_become_rgb(read) -> None:
    (rgb,), _ = read(Drive(LEGS))
    (bgr,), _ = read(Drive(LEGS, raw=True, encoding="bgr8", image="/camera/image_raw"))
    np.testing.assert_array_equal(bgr.image, rgb.image[..., ::-1])


def test_the_robot_of_the_settings_names_the_topics(read) -> None:
    robot = composed("train", "env=live", "robot=rosbridge", "robot/profile=turtlebot3", "robot.namespace=one").robot
    drive = Drive(LEGS, image="/one/camera/image_raw/compressed", odom="/one/odom")
    assert_equal(read(drive, [source.of(robot.profile, robot.namespace)])[0], read(Drive(LEGS))[0])
    with pytest.raises(BagError, match=r"lacks the images .* It has /one/camera/image_raw/compressed .*/one/odom"):
        read(drive)


def test_a_bag_of_two_robots_is_asked_about(read) -> None:
    sources = [Source("a", Drive.image, Drive.odom), Source("b", Drive.image, Drive.odom, crop=0.5)]
    with pytest.raises(BagError, match=r"fits a and b\. Name one"):
        read(Drive(LEGS), sources)
    assert len(read(Drive(LEGS), [sources[1]])[0]) == 1


def without_stamps(topic: str, number: int, fields: dict[str, Any]) -> dict[str, Any]:
    return {**fields, "stamp": 0.0}


def test_without_times_in_headers_the_recordings_count(read) -> None:
    assert_equal(read(Drive(LEGS, change=without_stamps))[0], read(Drive(LEGS))[0])


def at(key: str, topic: str, moment: float, by: float) -> Callable[[str, int, dict[str, Any]], dict[str, Any]]:
    """Add `by` to a field of all messages of a topic from a moment on."""
    def change(of: str, number: int, fields: dict[str, Any]) -> dict[str, Any]:
        late = of == topic and fields["stamp"] - STARTED >= moment
        return {**fields, key: fields[key] + by} if late else fields
    return change


def silent(topic: str, number: int, fields: dict[str, Any]) -> dict[str, Any] | None:
    return None if topic == ODOM and 2.0 < fields["stamp"] - STARTED < 4.0 else fields


def overtaken(topic: str, number: int, fields: dict[str, Any]) -> dict[str, Any]:
    """Every tenth message tells an earlier time than the one before."""
    return {**fields, "stamp": fields["stamp"] - 0.1 * (number % 10 == 9)}


def restarted(topic: str, number: int, fields: dict[str, Any]) -> dict[str, Any]:
    """The clock of odometry and camera starts anew."""
    return {**fields, "stamp": fields["stamp"] - 900.0 * (fields["stamp"] >= STARTED + 6.9)}


@pytest.mark.parametrize(("change", "said", "count"), [
    (at("x", ODOM, 3.0, 5.0), "jumps of the odometry", 2),
    (silent, "silences of the odometry", 2),
    (overtaken, "late odometry messages", 1),
    (overtaken, "late images", 1),
], ids=["jump", "silence", "late odometry", "late images"])
def test_what_cannot_be_used_is_counted(read, change, said: str, count: int) -> None:
    found, report = read(Drive(LEGS, change=change))
    assert len(found) == count and report["left_out"][said] >= 1
    assert sum(report["moves"]) == sum(map(len, found)) > 5


def test_a_clock_that_starts_anew_ends_an_episode(read) -> None:
    found, report = read(Drive(LEGS, change=restarted))
    assert report["left_out"] == {"restarts of the odometry's clock": 1}
    assert [len(episode) for episode in found] == [len(read(Drive(LEGS[:3]))[0][0]), 5]
    np.testing.assert_allclose(taken(found[1].image[0]), 6.9, atol=0.05)


@pytest.mark.parametrize("picture", [b"", b"no picture", b"\x89PNG\r\n\x1a\n"])
def test_a_broken_image_cuts_its_episode_in_two(read, picture: bytes) -> None:
    (whole,), _ = read(Drive(LEGS))
    broken = round(25 * taken(whole.image[3]))
    data = np.frombuffer(picture, np.uint8)
    found, report = read(Drive(LEGS, change=lambda topic, number, fields: {
        **fields, **({"data": data} if topic != ODOM and number == broken else {})}))
    assert [len(episode) for episode in found] == [2, len(whole) - 4]
    np.testing.assert_array_equal(np.concatenate([one.image for one in found]), np.delete(whole.image, 3, axis=0))
    assert [count for key, count in report["left_out"].items() if key.startswith(UNUSABLE)] == [1]


def test_the_process_of_its_own_gives_the_same(tmp_path: Path, read) -> None:
    (tmp_path / "out").mkdir()
    report = sandbox.convert(mcap(tmp_path / "bag", Drive(LEGS)), source.known(), tmp_path / "out", "a")
    assert_equal([Episode.load(tmp_path / "out" / "a_000000.npz")], read(Drive(LEGS))[0])
    assert report["episodes"] == 1 and [path.name for path in (tmp_path / "out").iterdir()] == ["a_000000.npz"]
