"""Many worlds at once, beside single ones with the same seeds."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import TimeLimit

from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.registration import register
from curionav_cli.world.scene import Scene
from curionav_cli.world.vector import NavigationVectorEnv

WORLDS, STEPS = 5, 60


@pytest.fixture
def lively(small) -> Scene:
    """Light drifts, a box moves, and the rest of a blocked move slides."""
    move = {"item": "box", "every": 1, "to": [[1.1, 0.5], [0.4, 1.2]]}
    return Scene.from_dict({**small, "collision": "slide", "moves": [move], "light": {"drift": 0.5, "period": 4}})


def same(one, other) -> bool:
    if isinstance(one, dict):
        return set(one) == set(other) and all(same(one[key], other[key]) for key in one)
    if one.dtype == object:
        return all(same(a, b) if isinstance(a, dict) else a == b for a, b in zip(one, other, strict=True))
    return one.dtype == other.dtype and one.tobytes() == other.tobytes()


@pytest.mark.parametrize("seed", [7, [3, 3, 0, 11, 5]])
def test_it_is_single_worlds_side_by_side_to_the_byte(lively: Scene, seed) -> None:
    """Gymnasium's own vector of single environments says what every array must be, at ends of episodes too."""
    ours = NavigationVectorEnv(lively, WORLDS, max_episode_steps=25)
    theirs = SyncVectorEnv([lambda: TimeLimit(NavigationEnv(lively), 25)] * WORLDS,
                           autoreset_mode=AutoresetMode.SAME_STEP)
    (seen, info), (expected, told) = ours.reset(seed=seed), theirs.reset(seed=seed)
    assert same(seen, expected) and same(info, told)
    ends = 0
    for actions in np.random.default_rng(1).integers(0, 3, (STEPS, WORLDS)):
        *step, info = ours.step(actions)
        *must, told = theirs.step(actions)
        assert same(step[0], must[0]) and all(same(a, b) for a, b in zip(step[1:], must[1:], strict=True))
        assert same(info, told)
        ends += step[3].sum()
    assert ends == 2 * WORLDS


def test_a_seed_may_be_any_integer(lively: Scene) -> None:
    ours, theirs = NavigationVectorEnv(lively, 2), NavigationVectorEnv(lively, 2)
    for seed in (np.int64(3), np.uint8(3), np.array([3, 4])):
        for (one, other) in zip(ours.reset(seed=seed), theirs.reset(seed=3), strict=True):
            assert same(one, other)


def test_gymnasium_makes_it(small_room: Scene) -> None:
    register()
    env = gymnasium.make_vec("curionav/SmallRoom-v0", num_envs=3, max_episode_steps=4, radius=0.2)
    assert isinstance(env.unwrapped, NavigationVectorEnv) and env.unwrapped.engine == "numpy"
    seen, _ = env.reset(seed=0)
    assert env.observation_space.contains(seen)
    for _ in range(4):
        seen, reward, terminated, truncated, info = env.step(env.action_space.sample())
    assert env.observation_space.contains(seen)
    assert truncated.all() and not terminated.any() and not reward.any()
    assert info["episode"].tolist() == [1, 1, 1] and info["final_info"]["episode"].tolist() == [0, 0, 0]
    assert env.unwrapped.now[0].plan.radius == 0.2


def test_nothing_ends_unless_told(small_room: Scene) -> None:
    env = NavigationVectorEnv(small_room, 2)
    env.reset(seed=0)
    for _ in range(30):
        _, _, terminated, truncated, info = env.step(np.array([0, 1]))
        assert not terminated.any() and not truncated.any() and "final_obs" not in info
    assert info["collided"].tolist() == [True, False]


def test_some_worlds_go_home_while_others_stay(lively: Scene) -> None:
    env = NavigationVectorEnv(lively, 3)
    env.reset(seed=4)
    seen, *_ = env.step(np.array([1, 1, 2]))
    back, info = env.reset(options={"reset_mask": np.array([False, True, False])})
    assert info["episode"].tolist() == [0, 1, 0] and info["_pose"].tolist() == [False, True, False]
    assert same(back["image"][[0, 2]], seen["image"][[0, 2]])
    assert env.reset(seed=4, options={"episode": 6})[1]["episode"].tolist() == [6, 6, 6]
    alone, _ = NavigationEnv(lively).reset(seed=5, options={"episode": 6})
    assert same(env.render()[1], alone["image"])


def test_other_poses_and_all_around(lively: Scene) -> None:
    env, single = NavigationVectorEnv(lively, 3), NavigationEnv(lively)
    seen, _ = env.reset(seed=2)
    around = env.panorama(6)
    assert around["image"].shape == (3, 6, 64, 64, 3) and around["depth"].shape == (3, 6, 64, 64)
    assert same(np.ascontiguousarray(around["image"][:, 0]), seen["image"])
    there = env.look(np.full(3, 0.6), np.full(3, 1.0), np.full(3, 0.3))
    single.reset(seed=3)
    assert same(single.panorama(6)["depth"], np.ascontiguousarray(around["depth"][1]))
    assert same(single.look(0.6, 1.0, 0.3)["image"][0], there["image"][1])
    with pytest.raises(ValueError, match="not 5"):
        env.panorama(5)


def test_an_observation_is_the_owner_s_to_change(small_room: Scene) -> None:
    env = NavigationVectorEnv(small_room, 2)
    first, _ = env.reset(seed=0)
    kept = first["image"].copy()
    first["image"][:] = 0
    env.step(np.array([1, 1]))
    back, *_ = env.step(np.array([2, 2]))
    assert np.array_equal(back["image"], kept)


@pytest.mark.parametrize("actions", [[0, 3], [0], [0, -1]])
def test_wrong_actions_are_refused(small_room: Scene, actions: list[int]) -> None:
    env = NavigationVectorEnv(small_room, 2)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="are not 2 of 0 forward"):
        env.step(np.array(actions))
