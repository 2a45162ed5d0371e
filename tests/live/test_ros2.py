"""A real ROS 2 robot behind a real rosbridge server, neither of them ours: make ros-peer installs them in .peers."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from entry import Cli
from tiny import LEARNER

from curionav_cli.config.compose import compose
from curionav_cli.config.override_errors import OverrideErrors
from curionav_cli.config.sources import opened
from curionav_cli.constants import FORWARD, LEFT
from curionav_cli.errors import RunFailed
from curionav_cli.live import connect
from curionav_cli.live.env import LiveRobot
from curionav_cli.live.rosbridge import Rosbridge
from curionav_cli.live.transport import ENDED, Goal
from curionav_cli.records import Episode
from curionav_cli.robot.docking.action import GoalState
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.real_floor import RealFloor

sys.path.insert(0, str(Path(__file__).parents[1] / "peers"))

from ros_peer import READY, Peer

pytestmark = [pytest.mark.ros2, pytest.mark.timeout(900),
              pytest.mark.skipif(not READY.exists(), reason="no ROS 2 peer: make ros-peer")]
CONF = Path(__file__).parents[1] / "peers" / "conf"
ACTION = "test_msgs/action/Fibonacci"
STALE = 8.0  # s; this machine may be busy
STOPPED = 1.0  # s after which nothing moves the wheels, once we have noticed


@pytest.fixture
def peer(tmp_path: Path) -> Iterator[Peer]:
    """A robot and its bridge, of this test alone."""
    made = Peer(tmp_path)
    yield made
    made.stop()


@pytest.fixture
def words(peer: Peer, request: pytest.FixtureRequest) -> list[str]:
    """The settings that lead to the peer, and those of the test's parameter."""
    return ["env=live", "robot=rosbridge", "robot/profile=peer", "robot.host=127.0.0.1", f"robot.port={peer.port}",
            f"robot.stale={STALE}", "robot.move=10", "robot.connect=20", "robot.patience=60",
            *getattr(request, "param", ())]


@pytest.fixture
def env(words: list[str], monkeypatch: pytest.MonkeyPatch) -> Iterator[LiveRobot]:
    """The environment of the peer, connected; asked holds what a person was asked."""
    asked: list[str] = []
    monkeypatch.setattr(connect, "ask", asked.append)
    with opened("explore", CONF) as hydra:
        settings = compose(hydra, OverrideErrors(hydra, words), words)[0]
    robot = connect.live_robot(settings.robot, RealFloor.of(settings.env), print)
    robot.asked = asked
    yield robot
    robot.close()


def wait(ready: Callable[[], bool], seconds: float = 90.0) -> bool:
    until = time.monotonic() + seconds
    while not ready() and time.monotonic() < until:
        time.sleep(0.05)
    return ready()


def ended(goal: Goal) -> GoalState:
    wait(lambda: goal.state in ENDED)
    return goal.state


def standing(peer: Peer) -> bool:
    return not peer.moves or peer.moves[-1][1:] == (0.0, 0.0)


def stopped(peer: Peer) -> bool:
    """Whether the wheels come to stand, and nothing sets them in motion later than STOPPED seconds from now."""
    most = time.monotonic() + STOPPED  # the clock of the robot's lines, too
    return wait(lambda: standing(peer)) and all(at < most for at, *velocity in peer.moves if any(velocity))


def until_closed(env: LiveRobot, steps: int = 6) -> str:
    for step in range(steps):
        if env.step(LEFT if step % 2 else FORWARD)[3]:
            return str(env.events[-1]["why"])
    raise AssertionError("the episode went on")


def test_actions_succeed_are_aborted_and_are_cancelled(peer: Peer) -> None:
    link, heard = Rosbridge("127.0.0.1", peer.port, 2, 20.0), list[dict]()
    link.subscribe("/odom", "nav_msgs/msg/Odometry", heard.append)
    assert wait(lambda: bool(heard))  # a goal that is sent before robot and bridge have found each other is lost
    try:
        assert ended(link.action("/dock", ACTION, {})) is GoalState.succeeded
        peer.tell("dock abort")
        assert ended(link.action("/dock", ACTION, {})) is GoalState.aborted
        peer.tell("dock hang")
        goal = link.action("/dock", ACTION, {})
        assert wait(lambda: peer.said("GOAL") == 3) and goal.state is GoalState.active
        goal.cancel()
        assert ended(goal) is GoalState.preempted
    finally:
        link.close()


def test_the_world_model_learns_on_the_robot_which_docks_between_episodes(peer: Peer, words, cli: Cli) -> None:
    small = [word for word in LEARNER if not word.startswith(("env=", "loop."))]
    answer = cli("explore", "-cd", str(CONF), *words, *small, "loop.steps=16", "loop.episodes=3", "loop.iterations=4",
                 "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    episodes = [Episode.load(path) for path in RunFolder(Path("run")).episode_paths()]
    assert [len(one) for one in episodes] == [16, 16, 16]
    assert [one.dock and one.dock["code"] for one in episodes] == [None, "docked", "docked"]
    assert all(one.image.std() > 5 for one in episodes)
    assert wait(lambda: standing(peer))


def test_check_finds_what_is_there(words, cli: Cli, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CURIONAV_CONFIG_PATH", str(CONF))
    answer = cli("robot", "check", "peer", *words[3:], "--move")
    assert answer.code == 0 and not answer.error, answer.out
    assert "Nothing to mend" in answer.out and "move ahead" in answer.out and "turn left" in answer.out


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_a_bridge_that_dies_or_hangs_stops_the_robot_and_comes_back(peer: Peer, env: LiveRobot, how) -> None:
    env.reset(seed=0)
    assert not env.step(FORWARD)[3]
    peer.bridge.send_signal(how)
    why = until_closed(env)
    assert "connection to the robot is lost" in why or "silent" in why or "no image" in why
    assert stopped(peer)
    if how is signal.SIGKILL:
        peer.bridge.wait()
        peer.bridge = peer.start_bridge()
    else:
        peer.bridge.send_signal(signal.SIGCONT)
    _, info = env.reset()
    assert info["episode_index"] == 1 and not env.step(LEFT)[3]


def test_a_robot_that_hangs_ends_the_run_in_a_line(peer: Peer, words, env: LiveRobot) -> None:
    env.reset(seed=0)
    env.settings = replace(env.settings, patience=5.0)
    peer.robot.send_signal(signal.SIGSTOP)
    assert "has been silent" in until_closed(env) or "no image" in env.events[-1]["why"]
    with pytest.raises(RunFailed, match="has been silent"):
        env.reset()


def test_faults_of_sensors_close_the_episode_and_the_next_begins(peer: Peer, env: LiveRobot) -> None:
    env.reset(seed=0)
    peer.tell("encoding bgr8")
    assert not env.step(LEFT)[3]
    peer.tell("silent image")
    assert "image" in until_closed(env) and stopped(peer)
    peer.tell("speak image")
    env.reset()
    peer.tell("encoding yuv422")
    assert "encoding 'yuv422'" in until_closed(env)
    peer.tell("encoding rgb8")
    env.reset()
    peer.tell("jump 3.0")
    assert "odometry jumped" in until_closed(env)
    _, info = env.reset()
    assert info["dock"]["human"] and len(env.asked) == 1


def test_images_of_another_size_and_encoding_and_those_overtaken_go_on(peer: Peer, env: LiveRobot) -> None:
    env.reset(seed=0)
    for line in ("side 96", "encoding bgr8", "side 32", "encoding rgb8", "metres 16UC1", "late 30", "side 64"):
        peer.tell(line)
        seen, _, _, closed, _ = env.step(LEFT)
        assert not closed and env.observation_space.contains(seen) and seen["image"].std() > 5, env.events
        assert 0.2 < seen["depth"].min() < seen["depth"].max() <= 12.0


@pytest.mark.parametrize("words", [("robot.profile.velocity.name=/cmd_vel_plain", "robot.twist=plain")], indirect=True)
def test_velocity_commands_without_a_header_drive_it(peer: Peer, env: LiveRobot) -> None:
    env.reset(seed=0)
    before = env.base.metres
    assert not env.step(FORWARD)[3] and env.base.metres - before > 0.15
    assert wait(lambda: standing(peer)) and any(speed > 0.1 for _, speed, _ in peer.moves)


@pytest.mark.parametrize(("word", "line"), [
    ("robot.profile.image.type=sensor_msgs/msg/CompressedImage", "/image has another type"),
    ("robot.profile.depth.type=nav_msgs/msg/Odometry", "/depth has another type"),
    ("robot.twist=plain", "/cmd_vel does not reach the robot; the server says: /cmd_vel has another type"),
    ("robot.profile.undock.type=test_msgs/action/Nothing", "/undock was aborted ("),
])
def test_a_wrong_message_type_is_answered_in_two_lines(words, cli: Cli, word: str, line: str) -> None:
    answer = cli("explore", "-cd", str(CONF), *words, word, "robot.patience=15", "robot.homing=30", "agent=bounce",
                 "loop.episodes=1", "loop.steps=4", "hydra.run.dir=run")
    assert answer.code == 1 and line in answer.error, answer.error
    assert len(answer.error.strip().splitlines()) <= 2 and "Traceback" not in answer.error


def test_docking_that_is_aborted_asks_for_a_person(peer: Peer, env: LiveRobot) -> None:
    env.reset(seed=0)
    env.step(FORWARD)
    peer.tell("dock abort")
    _, info = env.reset()
    assert info["dock"]["code"] == "action_aborted" and info["dock"]["attempts"] == 2 and len(env.asked) == 1


@pytest.mark.slow
def test_an_episode_of_500_steps(peer: Peer, words, cli: Cli) -> None:
    answer = cli("explore", "-cd", str(CONF), *words, "agent=bounce", "loop.episodes=1", "hydra.run.dir=run")
    assert answer.code == 0, answer.error
    episode = Episode.load(RunFolder(Path("run")).episode_path(0))
    assert len(episode) == 500 and episode.events == ()
