"""The robot as a Gymnasium environment: cancelled moves, battery, records, a run that continues after a crash."""

import json
import signal
from dataclasses import replace

import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from test_resume import KILLED

from curionav_cli.agents.baselines import Bounce
from curionav_cli.constants import FORWARD, LEFT, STEP_LENGTH
from curionav_cli.loop import run_episode
from curionav_cli.records import Episode
from curionav_cli.robot.env import RobotEnv
from curionav_cli.world.env import NavigationEnv


def a_robot(scene, profile, seed=0, pictures=False):
    env = RobotEnv(NavigationEnv(scene), profile, pictures)
    return env, env.reset(seed=seed)


@pytest.mark.filterwarnings("ignore:.*not inherit:UserWarning", "ignore:.*different.*unwrapped:UserWarning")
def test_gymnasium_finds_nothing_to_complain_of(small_room, turtlebot):
    check_env(RobotEnv(NavigationEnv(small_room), turtlebot), skip_render_check=True)


def test_the_agent_sees_what_the_true_pose_shows(small_room, turtlebot):
    env, (observation, info) = a_robot(small_room, turtlebot, pictures=True)
    for action in (FORWARD, LEFT, FORWARD):
        observation, _, _, _, info = env.step(action)
    seen = env.env.look(*info["pose"])
    assert np.array_equal(observation["image"], seen["image"][0])
    assert 0 < np.abs(info["pose"] - info["estimate"]).max() < 0.2


def test_the_lidar_is_in_info_from_the_first_step_on(small_room, turtlebot):
    env, (_, info) = a_robot(small_room, turtlebot)
    assert info["lidar"].shape == (2, turtlebot.lidar.beams) and np.isnan(info["lidar"][1]).all()
    _, _, _, _, info = env.step(LEFT)
    bearing, ranges = info["lidar"]
    x, y, yaw = info["pose"]
    seen = np.isfinite(ranges)
    ends = x + ranges[seen] * np.cos(yaw + bearing[seen]), y + ranges[seen] * np.sin(yaw + bearing[seen])
    assert seen.mean() > 0.9 and min(map(np.min, ends)) > -0.1 and ends[0].max() < 2.1 and ends[1].max() < 4.1


def test_a_wrong_action_is_named(small_room, turtlebot):
    env, _ = a_robot(small_room, turtlebot)
    with pytest.raises(ValueError, match="none of 0 forward"):
        env.step(3)


def test_no_step_without_a_reset(small_room, turtlebot):
    with pytest.raises(ResetNeeded, match=r"call reset\(\) first"):
        RobotEnv(NavigationEnv(small_room), turtlebot).step(FORWARD)


def test_info_and_reward_are_those_of_the_world(small_room, turtlebot):
    env = RobotEnv(NavigationEnv(small_room, reward="coverage"), turtlebot, pictures=False)
    infos, earned = [env.reset(seed=0)[1]], []
    for _ in range(4):
        _, reward, _, _, info = env.step(FORWARD)
        infos.append(info)
        earned.append(reward)
    cells = {tuple(map(int, small_room.plan.cells(*info["pose"][:2]))) for info in infos}
    assert sum(earned) == len(cells) - 1 > 0 and env.get_wrapper_attr("events") == ()
    assert [info["collided"].dtype for info in infos] == [bool] * 5 and infos[0]["episode_index"].dtype == np.int64


def test_a_move_is_cancelled_exactly_when_depth_shows_its_corridor_occupied(large_lab, quiet):
    """From 3000 places: never where the way is free; and where it is not, only if no beam met what is in it."""
    env, _ = a_robot(large_lab, quiet)
    rng, rows_columns = np.random.default_rng(0), np.argwhere(env.env.now.plan.visitable)
    radius, around, cancelled, hidden = large_lab.plan.radius, env.body.collision_world, 0, 0
    for row, column in rows_columns[rng.integers(0, len(rows_columns), 3000)]:
        x, y, yaw = (column + 0.5) * 0.1, (row + 0.5) * 0.1, rng.uniform(-np.pi, np.pi)
        env.body.pose = env.body.pose._replace(x=x, y=y, yaw=yaw)
        free = around.travel(x, y, STEP_LENGTH * np.cos(yaw), STEP_LENGTH * np.sin(yaw), radius) == STEP_LENGTH
        blocked = env._corridor_occupied()
        assert not (free and blocked)
        if not free and not blocked:
            scan = env.body.depth()
            ahead, aside = scan.range * np.cos(scan.bearing), np.abs(scan.range * np.sin(scan.bearing))
            assert not ((aside < radius) & (ahead < STEP_LENGTH)).any()
            hidden += 1
        cancelled += blocked
    assert cancelled > 300 and 0 < hidden < cancelled / 3


def test_an_obstacle_in_the_blind_zone_is_driven_into_and_the_scans_detect_the_slip(small_room, turtlebot):
    """The west wall is 0.2 m away, nearer than depth can see, and the bumper is silent."""
    env, _ = a_robot(small_room, turtlebot)
    env.body.pose = env.body.pose._replace(x=0.2, y=2.0, yaw=np.pi)
    env.body.silent.add("bumper")
    env.localiser.leave_dock(env.body.pose)
    env.localiser.update(env.body.drive(0.0, 0.0, 0.6), env.body.scan())
    before, pose = env.localiser.slips, env.body.pose
    assert not env._corridor_occupied()
    for _ in range(3):
        env.step(FORWARD)
    moved = np.hypot(env.body.pose.x - pose.x, env.body.pose.y - pose.y)
    estimated = np.hypot(env.localiser.pose.x - pose.x, env.localiser.pose.y - pose.y)
    assert moved < 0.05 and env.localiser.slips > before and estimated < 0.15, "the wheels say 0.3 m and more"


def test_a_low_battery_ends_the_episode_with_enough_for_the_return(small_room, turtlebot):
    profile = replace(turtlebot, battery=replace(turtlebot.battery, capacity=306.0))
    assert profile.steps == 10
    env, (observation, info) = a_robot(small_room, profile)

    class Watch:
        def acted(self, step):
            self.steps = step

    agent, watch = Bounce(0, 3, 18), Watch()
    episode = run_episode(env, agent, observation, info, 500, watch)
    assert len(episode) == watch.steps == 10 and env.body.battery.left == pytest.approx(300.0)
    assert episode.image.shape[0] == episode.pose.shape[0] == episode.estimate.shape[0] == 11


def test_an_episode_keeps_estimate_and_dock_and_one_of_an_ideal_robot_its_bytes(tmp_path, an_episode):
    plain = an_episode()
    robot = replace(plain, estimate=plain.pose + 0.1, dock={"code": "docked", "arrival": [1.0, 0.0, 0.0]})
    first = replace(robot, dock=None)
    for name, episode in (("plain", plain), ("robot", robot), ("first", first)):
        episode.save(tmp_path / name)
        loaded = Episode.load(tmp_path / name)
        assert loaded.dock == episode.dock
        assert np.array_equal(loaded.estimate, episode.estimate) if episode.estimate is not None else \
            loaded.estimate is None
    assert "estimate" not in np.load(tmp_path / "plain").files


@pytest.mark.parametrize("localisation", ["scan_odometry", "scan_to_map"])
def test_a_loaded_run_continues_as_if_uninterrupted(small_room, turtlebot, tmp_path, localisation):
    profile = replace(turtlebot, localisation=type(turtlebot.localisation)(localisation))

    def drive(env, steps):
        return [env.step(FORWARD if t % 4 else LEFT)[4]["pose"].tolist() for t in range(steps)]

    env, _ = a_robot(small_room, profile, seed=5)
    drive(env, 30)
    env.save(tmp_path)
    _, info = env.reset()
    after = drive(env, 10)
    other = RobotEnv(NavigationEnv(small_room), profile, pictures=False)
    other.load(tmp_path)
    _, same = other.reset(seed=5, options={"episode": 1})
    assert same["dock"] == info["dock"] and info["dock"]["code"] and same["episode_index"] == 1
    assert same["pose"].tolist() == info["pose"].tolist()
    assert drive(other, 10) == after


def test_a_killed_run_of_the_robot_ends_as_an_undisturbed_one(tmp_path, warm):
    words = ("env=small_room", "robot=turtlebot2i", "agent=bounce", "loop.steps=12", "loop.episodes=4")

    whole, killed = tmp_path / "whole", tmp_path / "killed"
    assert warm("explore", *words, f"hydra.run.dir={whole}").returncode == 0
    end = warm("acting", "explore", *words, f"hydra.run.dir={killed}", program=KILLED)
    assert end.returncode == -signal.SIGKILL, end.stderr
    resumed = warm("resume", str(killed))
    assert resumed.returncode == 0, resumed.stderr
    assert "goes on after 2 finished episodes" in resumed.stdout
    for index in range(4):
        name = f"episodes/{index:06d}.npz"
        assert (killed / name).read_bytes() == (whole / name).read_bytes()
    assert json.loads((killed / "checkpoint/000004/robot.json").read_text()) == \
        json.loads((whole / "checkpoint/000004/robot.json").read_text())
    assert Episode.load(killed / "episodes/000003.npz").dock["code"]
