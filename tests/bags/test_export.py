"""curionav export --to mcap, read back by the mcap package, which is not what wrote it."""

from __future__ import annotations

import json
import math
from collections import defaultdict
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from entry import Cli

from curionav_cli import build
from curionav_cli.bags.intake import episodes
from curionav_cli.config.settings import read_settings
from curionav_cli.records import Episode
from curionav_cli.storage.robot_map import explored_part, newest_map
from curionav_cli.storage.run_folder import RunFolder

mcap_reader = pytest.importorskip("mcap.reader")
mcap_ros2 = pytest.importorskip("mcap_ros2.decoder")

TINY = ("explore", "env=small_room", "loop.steps=20", "loop.episodes=2", "hydra.run.dir=run")
DEPTH, ODOM = "/oakd/stereo/image_raw", "/odom"
IMAGE = "/oakd/rgb/preview/image_raw/compressed"


def topics(bag: Path) -> dict[str, list[tuple[int, Any]]]:
    """The messages of a bag by topic, each with its time; every checksum is compared."""
    found = defaultdict(list)
    with open(bag / f"{bag.name}.mcap", "rb") as file:
        reader = mcap_reader.make_reader(file, validate_crcs=True, decoder_factories=[mcap_ros2.DecoderFactory()])
        for schema, channel, raw, message in reader.iter_decoded_messages():
            assert schema.encoding == "ros2msg" and channel.message_encoding == "cdr"
            found[channel.topic].append((raw.log_time, message))
    return found


def decoded(message: Any) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(message.data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def planar(pose: Any) -> np.ndarray:
    """x, y, yaw of a pose or transform."""
    place = getattr(pose, "position", None) or pose.translation
    turned = getattr(pose, "orientation", None) or pose.rotation
    return np.array([place.x, place.y, 2.0 * math.atan2(turned.z, turned.w)])


def assert_same_pose(found: np.ndarray, expected: np.ndarray) -> None:
    difference = found - expected
    difference[2] = (difference[2] + math.pi) % (2.0 * math.pi) - math.pi
    np.testing.assert_allclose(difference, 0.0, atol=1e-9)


@pytest.fixture(params=[("agent=mapper",), ("agent=bounce", "robot=turtlebot2i")], ids=["ideal", "turtlebot2i"])
def exported(request, cli: Cli, tmp_path: Path) -> tuple[RunFolder, Path]:
    """A run and its bags."""
    assert cli(*TINY, *request.param).code == 0
    answer = cli("export", "run", "--to", "mcap")
    assert answer.code == 0 and "curionav train data=run/bags" in answer.out, answer.error
    return RunFolder(tmp_path / "run"), tmp_path / "run" / "bags"


def test_another_reader_finds_the_episode(exported: tuple[RunFolder, Path]) -> None:
    run, bags = exported
    assert [path.name for path in sorted(bags.iterdir())] == ["episode_000000", "episode_000001"]
    for number in (0, 1):
        episode, found = Episode.load(run.episode_path(number)), topics(bags / f"episode_{number:06d}")
        assert {key: len(some) for key, some in found.items()} == {
            "/episode": 1, "/map": 1, "/tf_static": 1, IMAGE: 21, DEPTH: 21, ODOM: 21, "/tf": 21, "/state": 21,
            "/action": 20, **({"/estimate": 21} if episode.estimate is not None else {})}
        np.testing.assert_array_equal([decoded(message) for _, message in found[IMAGE]], episode.image)
        assert [message.data for _, message in found["/action"]] == [[action] for action in episode.action]
        assert [time for time, _ in found["/action"]] == [time for time, _ in found[IMAGE]][:-1]
        assert np.diff([time for time, _ in found[IMAGE]]).tolist() == [10**8] * 20
        np.testing.assert_array_equal([message.data[:3] for _, message in found["/state"]], episode.pose)
        assert [message.data[3] for _, message in found["/state"]][1:] == episode.collided.tolist()
        believed = episode.pose if episode.estimate is None else episode.estimate
        for (_, odometry), (_, transforms), pose, true in zip(found[ODOM], found["/tf"], believed, episode.pose):
            assert_same_pose(planar(odometry.pose.pose), pose)
            drift, base = (planar(one.transform) for one in transforms.transforms)
            cosine, sine = math.cos(drift[2]), math.sin(drift[2])
            assert_same_pose(np.array([drift[0] + cosine * base[0] - sine * base[1],
                                       drift[1] + sine * base[0] + cosine * base[1], drift[2] + base[2]]), true)
        told = json.loads(found["/episode"][0][1].data)
        assert (told["env"], told["episode"], told["steps"], told["seed"]) == ("small_room", number, 20, 0)


def test_depth_and_the_map_are_those_of_the_run(exported: tuple[RunFolder, Path]) -> None:
    run, bags = exported
    episode, found = Episode.load(run.episode_path(0)), topics(bags / "episode_000000")
    settings = read_settings(run.config)
    env = build.ideal_env(settings, build.scene(settings))
    env.reset(seed=0)
    seen = env.look(*episode.pose.T)
    depth = [np.frombuffer(message.data, np.float32).reshape(64, 64) for _, message in found[DEPTH]]
    np.testing.assert_allclose(depth, seen["depth"], atol=1e-5)
    assert {message.encoding for _, message in found[DEPTH]} == {"32FC1"}
    grid = found["/map"][0][1]
    cells, corner = explored_part(newest_map(run), run.path)
    np.testing.assert_array_equal(np.array(grid.data).reshape(grid.info.height, grid.info.width), cells)
    assert (grid.info.origin.position.x, grid.info.origin.position.y) == corner
    assert grid.header.frame_id == ("map" if episode.estimate is None else "odom")


def test_settings_of_the_command(cli: Cli, tmp_path: Path) -> None:
    assert cli(*TINY, "agent=random").code == 0
    answer = cli("export", "run", "to=mcap", "out=other", "episodes=last", "images=raw", "depth=no", "rate=4",
                 "profile=turtlebot3")
    assert answer.code == 0, answer.error
    assert [path.name for path in (tmp_path / "other").iterdir()] == ["episode_000001"]
    episode = Episode.load(tmp_path / "run" / "episodes" / "000001.npz")
    found = topics(tmp_path / "other" / "episode_000001")
    images = [message for _, message in found["/camera/image_raw"]]
    assert {(one.height, one.width, one.encoding, one.step) for one in images} == {(64, 64, "rgb8", 192)}
    np.testing.assert_array_equal([np.frombuffer(message.data, np.uint8).reshape(64, 64, 3) for message in images],
                                  episode.image)
    assert not any("depth" in topic or "stereo" in topic for topic in found)
    assert found["/camera/image_raw"][1][0] - found["/camera/image_raw"][0][0] == 250_000_000
    plan = RunFolder(tmp_path / "run").plan  # no map of its own: the scene's
    np.testing.assert_array_equal(np.array(found["/map"][0][1].data).reshape(plan.solid.shape) == 100, plan.solid)
    metadata = yaml.safe_load((tmp_path / "other" / "episode_000001" / "metadata.yaml").read_text())
    assert metadata["rosbag2_bagfile_information"]["storage_identifier"] == "mcap"


def test_bags_of_several_runs_lie_beside_one_another(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", "-m", "env=small_room", "agent=random", "seed=0,1", "loop.steps=3", "loop.episodes=1",
               "hydra.sweep.dir=sweep").code == 0
    assert cli("export", "sweep", "--to=mcap", "--out=bags", "--depth=no").code == 0
    assert [path.name for path in sorted((tmp_path / "bags").iterdir())] == [
        f"{seed}_small_room_random_{seed}_episode_000000" for seed in (0, 1)]


def test_depth_is_of_the_changed_world_and_left_out_where_images_differ(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", "env=large_lab", "agent=bounce", "loop.steps=5", "loop.episodes=2",
               "hydra.run.dir=run").code == 0
    assert cli("export", "run", "to=mcap", "out=bags").code == 0
    assert len(topics(tmp_path / "bags" / "episode_000001")[DEPTH]) == 6
    run = RunFolder(tmp_path / "run")
    episode = Episode.load(run.episode_path(1))
    changed = replace(episode, image=255 - episode.image)
    run.save_episode(1, changed)
    answer = cli("export", "run", "to=mcap", "out=again", "episodes=1")
    assert answer.code == 0 and "episode 1 has no depth: its images are not what is drawn" in answer.out
    assert DEPTH not in topics(tmp_path / "again" / "episode_000001")
    run.save_episode(1, replace(changed, depth=np.full((6, 64, 64), 1.5, np.float32)))  # as one made from a bag
    assert cli("export", "run", "to=mcap", "out=own", "episodes=1").code == 0
    (own,) = episodes(tmp_path / "own" / "episode_000001", [], {})
    assert own.depth.shape == (6, 64, 64) and (own.depth == 1.5).all()


@pytest.mark.parametrize(("words", "said"), [
    (("run",), "Name the format"),
    (("to=mcap",), "Name the folder of a run"),
    (("run", "to=bag"), "is not one of mcap"),
    (("nowhere", "to=mcap"), "There is no folder"),
    (("run", "to=mcap", "episodes=7"), "has no episode 7. It has 0 to 0"),
    (("run", "to=mcap", "episodes=a"), "is not a list of episodes"),
    (("run", "to=mcap", "rate=0"), "is not a number of steps a second"),
    (("run", "to=mcap", "rate=fast"), "is not a number of steps a second"),
    (("run", "to=mcap", "profile=turtlebot"), "Did you mean turtlebot"),
    (("run", "to=mcap", "images=jpeg"), "is not one of png, raw"),
    (("run", "to=mcap", "out=there"), "exists already. Name another folder"),
    (("begun", "to=mcap"), "has no episodes"),
])
def test_mistakes_are_answered_in_a_line(cli: Cli, tmp_path: Path, an_episode, a_plan, words, said: str) -> None:
    for name in ("run", "begun"):
        RunFolder(tmp_path / name).create("env: {name: small_room}\n", {}, {}, a_plan())
    RunFolder(tmp_path / "run").save_episode(0, an_episode())
    (tmp_path / "there" / "episode_000000").mkdir(parents=True)
    answer = cli("export", *words)
    assert answer.code == 2 and said in answer.error and len(answer.error.strip().splitlines()) == 1, answer.error


def test_without_the_extra_a_line_names_it(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("curionav_cli.bags.library.find_spec", lambda name: None)
    answer = cli("export", "run", "to=mcap")
    assert answer.code == 2 and "pip install -c constraints.txt -e '.[bags]'" in answer.error
