"""Export, and train on the bags: the episodes are equal, and so is what is learned from them."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from entry import Cli
from leftovers import repeatable

from curionav_cli.bags import cache, source
from curionav_cli.bags.export import Form, write
from curionav_cli.bags.intake import episodes
from curionav_cli.errors import RunFolderError
from curionav_cli.records import Episode

TINY = ("agent=lbs_dreamer", "agent.action_repeat=1", "agent.sequence_length=5", "agent.batch_size=4")


def rows(run: Path) -> list[dict[str, object]]:
    """The metrics of a run, without what was measured of its process."""
    found = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    return [{key: value for key, value in row.items() if "time" not in key} for row in repeatable(found)]


def kept(tmp_path: Path) -> list[Path]:
    return sorted((tmp_path / "cache" / "curionav" / "bags").glob("*/*.npz"))


@pytest.mark.parametrize("words", [
    ("env=small_room", "agent=bounce", "robot=turtlebot2i"), ("env=large_lab", "agent=bounce"),
], ids=["turtlebot2i", "changing"])
def test_the_episodes_are_equal_to_the_byte(cli: Cli, tmp_path: Path, words: tuple[str, ...]) -> None:
    assert cli("explore", *words, "loop.steps=12", "loop.episodes=2", "hydra.run.dir=run").code == 0
    for images in ("png", "raw"):
        assert cli("export", "run", "to=mcap", f"out={images}", f"images={images}", "depth=no").code == 0
        for number in (0, 1):
            (found,) = episodes(tmp_path / images / f"episode_{number:06d}", [], {})
            found.save(tmp_path / "found.npz")
            stored = tmp_path / "run" / "episodes" / f"{number:06d}.npz"
            assert (tmp_path / "found.npz").read_bytes() == stored.read_bytes()


def test_depth_comes_back(tmp_path: Path, an_episode) -> None:
    depth = np.random.default_rng(0).uniform(0.1, 9.0, (len(an_episode()) + 1, 64, 64)).astype(np.float32)
    write(tmp_path / "bag", an_episode(), 0, Form(source.named("turtlebot3"), True, 10.0, 0.3), depth, None, {})
    (found,) = episodes(tmp_path / "bag", [], {})
    found.save(tmp_path / "found.npz")
    np.testing.assert_array_equal(Episode.load(tmp_path / "found.npz", depth=True).depth, depth)
    assert Episode.load(tmp_path / "found.npz").depth is None
    dataclasses.replace(found, depth=depth[1:]).save(tmp_path / "short.npz")
    with pytest.raises(RunFolderError, match="holds depth of float32"):
        Episode.load(tmp_path / "short.npz", depth=True)


def test_training_on_bags_is_training_on_the_run(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", "env=small_room", "agent=random", "loop.steps=30", "loop.episodes=2",
               "hydra.run.dir=run").code == 0
    assert cli("export", "run", "to=mcap", "depth=no").code == 0
    for data, name in (("run", "a"), ("run/bags", "b")):
        answer = cli("train", *TINY, f"data={data}", "loop.iterations=3", f"hydra.run.dir={name}")
        assert answer.code == 0, answer.error
    assert answer.out.count("as curionav exported them") == 2
    assert rows(tmp_path / "a") == rows(tmp_path / "b") != []
    made = [path.stat().st_mtime_ns for path in kept(tmp_path)]
    resumed = cli("resume", "b", "loop.iterations=5")
    assert resumed.code == 0 and [path.stat().st_mtime_ns for path in kept(tmp_path)] == made


def test_the_cache_is_made_anew_and_a_changed_bag_is_another(tmp_path: Path, an_episode) -> None:
    form = Form(source.named("turtlebot4"), True, 10.0, 0.3)
    write(tmp_path / "bags" / "one", an_episode(), 0, form, None, None, {})
    first = cache.converted(cache.found(tmp_path / "bags"), source.known())
    (first / cache.REPORT).unlink()
    assert cache.converted(cache.found(tmp_path / "bags"), source.known()) == first and (first / cache.REPORT).is_file()
    write(tmp_path / "bags" / "two", an_episode(seed=1), 1, form, None, None, {})
    assert cache.converted(cache.found(tmp_path / "bags"), source.known()) != first


def test_moves_cut_from_the_odometry_are_the_actions(tmp_path: Path) -> None:
    """The other way to the same: without what curionav adds, the bag of a drive without a collision has its actions."""
    yaw, x, y = 0.0, 0.0, 0.0
    actions = np.random.default_rng(0).choice(3, 60, p=[0.6, 0.25, 0.15])
    poses = [(x, y, yaw)]
    for action in actions:
        yaw += np.radians([0.0, 10.0, -10.0])[action]
        x, y = x + 0.25 * (action == 0) * np.cos(yaw), y + 0.25 * (action == 0) * np.sin(yaw)
        poses.append((x, y, yaw))
    image = np.zeros((61, 64, 64, 3), np.uint8)
    image[:, :, :, 0] = np.arange(61)[:, None, None]
    episode = Episode(image, actions, np.array(poses), np.zeros(60, bool))
    write(tmp_path / "bag", episode, 0, Form(source.named("turtlebot4"), True, 2.0, 0.3), None, None, {})
    from curionav_cli.bags import recorded

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recorded, "is_ours", lambda bag: False)
        (found,) = episodes(tmp_path / "bag", source.known(), {})
    np.testing.assert_array_equal(found.action, actions)
    np.testing.assert_array_equal(found.image, image)
    np.testing.assert_allclose(found.pose, poses, atol=1e-12)
