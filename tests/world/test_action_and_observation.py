"""observation="image", action="continuous" and size= of the Gymnasium environments."""

from __future__ import annotations

import math

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from curionav_cli.world.continuous import SECONDS, SPEED, TURN
from curionav_cli.world.registration import register

ROOM = "curionav/SmallRoom-v0"


def room(**settings) -> gymnasium.Env:
    register()
    return gymnasium.make(ROOM, **settings)


@pytest.mark.filterwarnings("ignore:.*we recommend using a symmetric and normalized space:UserWarning")
@pytest.mark.parametrize("settings", [{"observation": "image"}, {"action": "continuous"},
                                      {"action": "continuous", "observation": "image", "collision": "slide"}])
def test_gymnasiums_checker_finds_no_fault(settings: dict[str, str]) -> None:
    check_env(room(render_mode="rgb_array", **settings).unwrapped)


def test_an_image_is_that_of_the_dict() -> None:
    alone, both = room(observation="image", max_episode_steps=2), room(max_episode_steps=2)
    assert np.array_equal(alone.reset(seed=1)[0], both.reset(seed=1)[0]["image"])
    assert np.array_equal(alone.step(1)[0], both.step(1)[0]["image"])
    many = gymnasium.make_vec(ROOM, num_envs=2, observation="image", max_episode_steps=2)
    seen, _ = many.reset(seed=[1, 1])
    assert many.observation_space.contains(seen) and np.array_equal(seen[0], both.reset(seed=1)[0]["image"])
    many.step(np.array([1, 1]))
    info = many.step(np.array([1, 1]))[-1]
    both.step(1)
    assert np.array_equal(info["final_obs"][1], both.step(1)[0]["image"])


def test_a_larger_size_is_drawn_and_not_stretched() -> None:
    """The same view with more pixels: blocks of four have about the mean of the small image, and differ inside."""
    small, large = room(), room(size=128)
    (seen, _), (fine, _) = small.reset(seed=1), large.reset(seed=1)
    assert large.observation_space.contains(fine) and large.observation_space["depth"].shape == (128, 128)
    blocks = fine["image"].reshape(64, 2, 64, 2, 3).astype(float)
    assert abs(blocks.mean((1, 3)) - seen["image"]).mean() < 6 and blocks.std((1, 3)).mean() > 1
    around = large.unwrapped.panorama(2)["depth"]
    assert np.array_equal(around[0], fine["depth"]) and abs(fine["depth"][::2, ::2] - seen["depth"]).mean() < 0.05


@pytest.mark.parametrize("action", ["discrete", "continuous"])
def test_many_worlds_of_another_size_equal_single_ones(action: str) -> None:
    kind = {"vectorization_mode": "sync"} if action == "continuous" else {}
    many = gymnasium.make_vec(ROOM, num_envs=2, size=96, observation="image", action=action, **kind)
    alone = room(size=96, observation="image", action=action)
    assert np.array_equal(many.reset(seed=[3, 4])[0][1], alone.reset(seed=4)[0])
    still = np.ones(2, np.int64) if action == "discrete" else np.zeros((2, 2), np.float32)
    seen, after = many.step(still)[0], alone.step(still[0])[0]
    assert seen.shape == (2, 96, 96, 3) and np.array_equal(seen[0], after)


@pytest.mark.parametrize("size", [62, 65, 514, 96.0, [96, 96]])
def test_another_size_is_refused(size: object) -> None:
    for make in (gymnasium.make, gymnasium.make_vec):
        with pytest.raises(ValueError, match=r"^size, the side of the images in pixels, must be an even integer from 64"
                                             " to 512, not "):
            make(ROOM, size=size)


def test_numba_draws_one_size() -> None:
    with pytest.raises(ValueError, match=r"engine='numba' draws images of 64 x 64 pixels, not size=96. Leave engine"):
        room(size=96, engine="numba")


def test_full_speed_is_a_step_forward_and_a_turn_takes_its_time() -> None:
    env, discrete = room(action="continuous"), room()
    _, start = env.reset(seed=0)
    discrete.reset(seed=0)
    seen, _, _, _, info = env.step(np.array([SPEED, 0.0], np.float32))
    also, _, _, _, other = discrete.step(0)
    assert np.allclose(info["pose"], other["pose"], atol=1e-7) and not info["collided"]
    assert (np.abs(seen["image"].astype(int) - also["image"]) > 2).mean() < 0.01
    before = info["pose"]
    info = env.step(np.array([0.0, TURN], np.float32))[4]
    assert np.allclose(info["pose"] - before, [0, 0, TURN * SECONDS]) and not np.array_equal(start["pose"], before)


def test_an_arc_is_a_circle() -> None:
    """A full circle of forty steps ends where it began; its radius is speed over turn rate."""
    env = room(action="continuous", max_episode_steps=-1)
    _, info = env.reset(seed=0)
    speed, rate = 0.02, 2 * math.pi / (40 * SECONDS)
    poses = [info["pose"]]
    for _ in range(40):
        info = env.step(np.array([speed, rate], np.float32))[4]
        assert not info["collided"]
        poses.append(info["pose"])
    where = np.array(poses)[:, :2]
    assert np.allclose(where[0], where[-1], atol=1e-5) and np.isclose(np.ptp(where[:, 0]), 2 * speed / rate, rtol=0.01)


def test_it_stops_at_a_wall_and_turns_there() -> None:
    env = room(action="continuous", max_episode_steps=-1)
    env.reset(seed=0)
    infos = [env.step(np.array([SPEED, 0.0], np.float32))[4] for _ in range(60)]
    assert infos[-1]["collided"] and np.array_equal(infos[-1]["pose"], infos[-2]["pose"])
    plan = env.unwrapped.scene.plan
    row, column = plan.cells(*np.array([info["pose"][:2] for info in infos]).T)
    assert plan.visitable[row, column].all()
    turned = env.step(np.array([SPEED, 0.5], np.float32))[4]["pose"]
    assert turned[2] != infos[-1]["pose"][2]
    assert env.unwrapped.panorama()["image"].shape == (4, 64, 64, 3)


@pytest.mark.parametrize("action", [[0.5, 0.0], [-0.1, 0.0], [0.1, 1.1], [np.nan, 0.0], [0.1], 0])
def test_an_action_outside_of_the_space_is_refused(action: object) -> None:
    env = room(action="continuous", disable_env_checker=True)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"no forward speed from 0 to 0.4167 m/s and turn rate from -1 to 1 rad/s"):
        env.step(np.array(action, np.float32))


def test_other_names_are_refused() -> None:
    with pytest.raises(ValueError, match="action must be one of discrete, continuous, not 'fast'"):
        room(action="fast")
    with pytest.raises(ValueError, match="observation must be one of dict, image, not 'depth'"):
        room(observation="depth")
    with pytest.raises(ValueError, match="Add vectorization_mode='sync'"):
        gymnasium.make_vec(ROOM, num_envs=2, action="continuous")
    apart = gymnasium.make_vec(ROOM, num_envs=2, vectorization_mode="sync",
                               action="continuous")
    assert apart.reset(seed=0)[0]["image"].shape == (2, 64, 64, 3)
