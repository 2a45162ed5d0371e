"""robot=rosbridge explores our own served world, as the in-process robot does; and curionav serve."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from entry import Cli
from worlds import LASTING, World, apart, placed

from curionav_cli import build
from curionav_cli.execution import exploration
from curionav_cli.live import connect
from curionav_cli.live.memory import Memory, OtherSide
from curionav_cli.records import Episode
from curionav_cli.storage.run_folder import RunFolder


def some_actions(count: int) -> list[int]:
    draws = np.random.default_rng(1)
    return [0 if draws.random() < 0.5 else int(draws.integers(1, 3)) for _ in range(count)]


def test_an_exact_robot_explores_over_topics_as_in_process() -> None:
    """A hundred steps in the small room: the same collisions, poses and images."""
    world = World("robot.profile=turtlebot4", "env=small_room", exact=True, images=10.0)
    live = world.explorer()
    live.reset(seed=0)
    settings = world.settings
    alone = build.robot_env(build.replace(settings, robot=world.robot.body.profile), build.scene(settings))
    alone.reset(seed=0)
    alone.body.place(alone.env.now, world.pose)
    collided = 0
    for action in some_actions(100):
        seen, _, _, closed, info = live.step(action)
        _, _, _, _, expected = alone.step(action)
        assert not closed and bool(info["collided"]) == bool(expected["collided"]), live.events
        assert apart(world.pose, alone.body.pose) < 1e-9
        views = alone.env.look(*world.pose)
        assert np.array_equal(seen["image"], views["image"][0]) and np.array_equal(seen["depth"], views["depth"][0])
        collided += bool(info["collided"])
    assert 10 < collided < 60


@pytest.mark.parametrize("profile", ["turtlebot3", "turtlebot4"])
def test_the_estimate_of_a_drifting_robot_is_off_by_the_drift_that_was_set(profile: str) -> None:
    world = World(f"robot.profile={profile}", "env=apartment_0", "seed=2", images=10.0)
    live = world.explorer()
    _, info = live.reset(seed=0)
    start, began = world.pose, info["pose"]
    for action in some_actions(60):
        _, _, _, closed, info = live.step(action)
        assert not closed, live.events
    turn = start.yaw - began[2]
    x, y = info["pose"][:2] - began[:2]
    estimate = placed(start._replace(x=x, y=y, yaw=info["pose"][2] - began[2]), start._replace(yaw=turn))
    metres, errors = live.base.metres, world.settings.robot
    off, sd = math.hypot(estimate.x - world.pose.x, estimate.y - world.pose.y), errors.odometry
    assert metres > 3.0
    assert 1e-3 < off < 3.0 * (sd.scale * metres + sd.noise * math.sqrt(metres)) + 0.02 * metres  # 0.02: of the heading


def test_an_agent_explores_a_served_world_and_docks_between_episodes(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    world, asked = World("robot.profile=turtlebot4", "env=small_room", "seed=1", images=10.0), list[str]()
    monkeypatch.setattr(connect, "live_robot", lambda settings, floor, say: world.explorer(asked))
    monkeypatch.setattr(connect, "refuse_unreachable", lambda settings: None)
    monkeypatch.setattr(exploration, "draw", lambda run: None)
    answer = cli("explore", "env=live", "robot=rosbridge", "robot.profile=turtlebot4", "agent=bounce", "loop.steps=12",
                 "loop.episodes=2", "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    episodes = [Episode.load(path) for path in RunFolder(Path("run")).episode_paths()]
    assert [len(episode) for episode in episodes] == [12, 12] and not any(one.events for one in episodes)
    assert [one.dock["code"] for one in episodes[1:]] == ["docked"] and not asked
    assert all(len(np.unique(one.image.reshape(13, -1), axis=0)) > 6 for one in episodes)


class Interrupting(Memory):
    """A connection behind which somebody types Ctrl-C at the hundredth odometry of each robot together."""

    def __init__(self) -> None:
        super().__init__({})
        self.counted: dict[str, int] = {}

    def send(self, topic, message) -> None:
        self.counted[topic] = self.counted.get(topic, 0) + 1
        super().send(topic, message)
        if sum(count for name, count in self.counted.items() if name.endswith("/odom")) > 100:
            raise KeyboardInterrupt


def test_the_command_serves_several_robots_until_it_is_stopped(cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    link = Interrupting()
    monkeypatch.setattr(connect, "transport", lambda settings: OtherSide(link))
    monkeypatch.setattr(connect, "refuse_unreachable", lambda settings: None)
    answer = cli("serve", "env=small_room", "robot.profile=turtlebot4", "robot.namespace=house", LASTING, "--robot",
                 "red", "--robot", "blue", "--speed", "20", "--images", "2", "--exact")
    assert answer.code == 0 and not answer.error and link.closed
    assert "/house/red/odom" in answer.out and "/house/blue/dock" in answer.out and "stopped" in answer.out
    assert {"/house/red/clock", "/house/blue/ground_truth", "/house/red/tf"} <= set(link.offered)
    assert link.offered["/house/red/cmd_vel"] == "geometry_msgs/msg/TwistStamped"
    assert min(link.counted[f"/house/{name}/odom"] for name in ("red", "blue")) > 20


@pytest.mark.parametrize(("words", "line"), [
    (("robot=ideal",), "Choose robot=turtlebot2i, with --exact"),
    (("env=live",), "a real floor, of which there is no scene"),
    (("robot.profile=turtlebot2i",), "is of ROS 1, whose actions are not served"),
    (("robot.profile=turtlebot5",), "Did you mean"),
    (("robot.profile.image.crop=0.5",), "served images are square"),
    (("robot.profile.battery.type=std_msgs/msg/Float32",), "battery of type std_msgs/msg/Float32 cannot be served"),
    (("robot.port=1", "robot.connect=0.5"), "No rosbridge server answers at ws://localhost:1"),
    (("--speed", "0"), "greater than or equal to 0.01"),
])
def test_what_cannot_be_served_is_answered_in_a_line(cli: Cli, words: tuple[str, ...], line: str) -> None:
    answer = cli("serve", *words)
    assert answer.code == 2 and line in answer.error and "Traceback" not in answer.error
