"""Many worlds at once, beside single ones with the same seeds."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.error import Error, ResetNeeded
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from gymnasium.wrappers import TimeLimit
from gymnasium.wrappers.vector import RecordEpisodeStatistics

from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.registration import register
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.vector_env import NavigationVectorEnv

WORLDS, STEPS = 5, 60


@pytest.fixture
def changing(small) -> Scene:
    """Light drifts, a box moves, and the rest of a blocked move slides."""
    move = {"item": "box", "every": 1, "to": [[1.1, 0.5], [0.4, 1.2]]}
    return Scene.from_dict({**small, "collision": "slide", "moves": [move], "light": {"drift": 0.5, "period": 4}})


def same(one, other) -> bool:
    if isinstance(one, dict):
        return set(one) == set(other) and all(same(one[key], other[key]) for key in one)
    if one.dtype == object:
        return all(same(a, b) if isinstance(a, dict) else a == b for a, b in zip(one, other, strict=True))
    return one.dtype == other.dtype and one.tobytes() == other.tobytes()


@pytest.mark.parametrize("reward", ["none", "coverage", "count"])
@pytest.mark.parametrize("mode", AutoresetMode)
@pytest.mark.parametrize("seed", [7, [3, 3, 0, 11, 5]])
def test_it_is_single_worlds_side_by_side_to_the_byte(changing: Scene, seed, mode: AutoresetMode, reward: str) -> None:
    """Gymnasium's own vector of single environments says what every array must be, at ends of episodes too."""
    ours = NavigationVectorEnv(changing, WORLDS, max_episode_steps=25, autoreset_mode=mode, reward=reward)
    theirs = SyncVectorEnv([lambda: TimeLimit(NavigationEnv(changing, reward=reward), 25)] * WORLDS,
                           autoreset_mode=mode)
    assert ours.metadata["autoreset_mode"] is ours.autoreset_mode is mode is theirs.metadata["autoreset_mode"]
    (seen, info), (expected, expected_info) = ours.reset(seed=seed), theirs.reset(seed=seed)
    assert same(seen, expected) and same(info, expected_info)
    ends = 0
    for actions in np.random.default_rng(1).integers(0, 3, (STEPS, WORLDS)):
        *step, info = ours.step(actions)
        *must, expected_info = theirs.step(actions)
        assert same(step[0], must[0]) and all(same(a, b) for a, b in zip(step[1:], must[1:], strict=True))
        assert same(info, expected_info)
        ends += step[3].sum()
        if mode is AutoresetMode.DISABLED and step[3].any():
            (seen, info), (expected, expected_info) = ours.reset(), theirs.reset()
            assert same(seen, expected) and same(info, expected_info)
    assert ends == 2 * WORLDS


def test_the_mode_may_be_named_as_gymnasium_names_it_and_no_other(small_room: Scene) -> None:
    assert NavigationVectorEnv(small_room, autoreset_mode="NextStep").autoreset_mode is AutoresetMode.NEXT_STEP
    assert NavigationVectorEnv.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    with pytest.raises(ValueError, match="must be one of NextStep, SameStep, Disabled, not 'Never'"):
        NavigationVectorEnv(small_room, autoreset_mode="Never")


def test_a_step_before_a_reset_raises_reset_needed(small_room: Scene) -> None:
    env = NavigationVectorEnv(small_room, 2, max_episode_steps=2, autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=0)
    env.step(np.array([1, 1]))
    env.reset(options={"reset_mask": np.array([False, True])})
    assert env.step(np.array([1, 1]))[3].tolist() == [True, False]
    with pytest.raises(ResetNeeded, match=r"of worlds \[0\] have ended: call reset"):
        env.step(np.array([1, 1]))
    _, info = env.reset(options={"reset_mask": np.array([True, False])})
    assert info["episode_index"].tolist() == [1, 1] and env.step(np.array([1, 1]))[3].tolist() == [False, True]


@pytest.mark.parametrize("steps", [2, 3])
@pytest.mark.parametrize("mode", [AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP])
def test_gymnasium_counts_every_episode_right(small_room: Scene, steps: int, mode: AutoresetMode) -> None:
    env = RecordEpisodeStatistics(
        NavigationVectorEnv(small_room, 2, max_episode_steps=steps, autoreset_mode=mode, reward="coverage"))
    env.reset(seed=0)
    infos = [env.step(np.array([0, 1]))[4] for _ in range(12)]
    assert [info["episode"]["l"].tolist() for info in infos if "episode" in info][:3] == [[steps, steps]] * 3
    assert infos[steps - 1]["episode"]["r"][0] > infos[steps - 1]["episode"]["r"][1] == 0.0


def test_no_step_without_a_reset(small_room: Scene) -> None:
    env = NavigationVectorEnv(small_room, 2)
    for call in (lambda: env.step(np.array([0, 0])), env.render, env.panorama,
                 lambda: env.reset(options={"reset_mask": np.array([True, False])})):
        with pytest.raises(ResetNeeded, match=r"call reset\(\) first"):
            call()


@pytest.mark.parametrize(("seed", "fault", "said"), [
    (-1, Error, "from 0 to"), (2**64, Error, "from 0 to"), (2**64 - 1, Error, "from 0 to"), ([0, -3], Error, "not -3"),
    ([0, 2**64], Error, "from 0 to"), (1.5, Error, "an integer or a list of 2, not 1.5"), ("ab", Error, "not 'ab'"),
    ([0.5, 1], Error, "an integer, not 0.5"),
    ([1], ValueError, "1 seeds for 2 worlds"), ([1, 2, 3], ValueError, "3 seeds for 2 worlds"),
])
def test_seeds_that_are_none_are_refused(small_room: Scene, seed, fault: type[Exception], said: str) -> None:
    with pytest.raises(fault, match=said):
        NavigationVectorEnv(small_room, 2).reset(seed=seed)


@pytest.mark.parametrize("options", [
    {"episode": "x"}, {"episode": -1}, {"reset_mask": np.zeros(2, bool)}, {"reset_mask": np.ones(3, bool)},
    {"reset_mask": [1, 0]}])
def test_options_that_are_none_are_refused(small_room: Scene, options: dict) -> None:
    (name,) = options
    with pytest.raises(ValueError, match=rf'options\["{name}"\] must be'):
        NavigationVectorEnv(small_room, 2).reset(options=options)


def test_its_random_generator_is_seeded(small_room: Scene) -> None:
    env = NavigationVectorEnv(small_room, 2)
    draws = []
    for seed in (5, [5, 9], 6):
        env.reset(seed=seed)
        draws.append(env.np_random.random())
    assert draws[0] == draws[1] != draws[2] and env.np_random_seed == 6
    env.reset(seed=2**64 - 2)


def test_seeds_in_every_reset_go_on_where_that_is_asked_for(changing: Scene) -> None:
    env = NavigationVectorEnv(changing, 2, reset_mode="continue")
    infos = [env.reset(seed=seed)[1] for seed in (4, 9)]
    alone = NavigationEnv(changing)
    alone.reset(seed=5, options={"episode": 1})
    assert infos[1]["episode_index"].tolist() == [1, 1] and env.events[1] == alone.events


def test_a_seed_may_be_any_integer(changing: Scene) -> None:
    ours, theirs = NavigationVectorEnv(changing, 2), NavigationVectorEnv(changing, 2)
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
    assert info["episode_index"].tolist() == [1, 1, 1] and info["final_info"]["episode_index"].tolist() == [0, 0, 0]
    assert env.unwrapped.now[0].plan.radius == 0.2


def test_no_episode_ends_unless_limited(small_room: Scene) -> None:
    env = NavigationVectorEnv(small_room, 2)
    env.reset(seed=0)
    for _ in range(30):
        _, _, terminated, truncated, info = env.step(np.array([0, 1]))
        assert not terminated.any() and not truncated.any() and "final_obs" not in info
    assert info["collided"].tolist() == [True, False]


def test_some_worlds_reset_while_others_stay(changing: Scene) -> None:
    env = NavigationVectorEnv(changing, 3)
    env.reset(seed=4)
    seen, *_ = env.step(np.array([1, 1, 2]))
    back, info = env.reset(options={"reset_mask": np.array([False, True, False])})
    assert info["episode_index"].tolist() == [0, 1, 0] and info["_pose"].tolist() == [False, True, False]
    assert same(back["image"][[0, 2]], seen["image"][[0, 2]])
    assert env.reset(seed=4, options={"episode": 6})[1]["episode_index"].tolist() == [6, 6, 6]
    alone, _ = NavigationEnv(changing).reset(seed=5, options={"episode": 6})
    assert same(env.render()[1], alone["image"])


def test_other_poses_and_all_around(changing: Scene) -> None:
    env, single = NavigationVectorEnv(changing, 3), NavigationEnv(changing)
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


def test_registered_episodes_have_500_steps_unless_set() -> None:
    register()
    limits = [gymnasium.make_vec("curionav/SmallRoom-v0", **settings).unwrapped.max_episode_steps
              for settings in ({}, {"max_episode_steps": -1}, {"max_episode_steps": 7})]
    assert limits == [500, None, 7]
    with pytest.raises(ValueError, match="max_episode_steps must be 1 or more, or None, not 0"):
        gymnasium.make_vec("curionav/SmallRoom-v0", max_episode_steps=0)


@pytest.mark.parametrize("actions", [[0, 3], [0], [0, -1], [0, 0.5], ["0", "1"]])
def test_wrong_actions_are_refused(small_room: Scene, actions: list[int]) -> None:
    env = NavigationVectorEnv(small_room, 2)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="are not 2 of 0 forward"):
        env.step(np.array(actions))
