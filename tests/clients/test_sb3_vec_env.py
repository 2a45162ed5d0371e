"""Our native vector environment as one of Stable-Baselines3's, beside its own DummyVecEnv of single worlds."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from test_sb3 import ROOM, trainer

from curionav_cli.world.registration import register

pytestmark = [pytest.mark.clients, pytest.mark.filterwarnings("ignore::DeprecationWarning"),
              pytest.mark.usefixtures("sb3")]
SETTINGS = {"reward": "coverage", "max_episode_steps": 20, "render_mode": "rgb_array"}
LAB = "curionav/LargeLab-v0"


def native(name: str = ROOM, worlds: int = 3, **settings):
    from curionav_cli.agents.sb3.vec_env import SB3VecEnv

    register()
    return SB3VecEnv(gymnasium.make_vec(name, num_envs=worlds, **SETTINGS, **settings))


def theirs(name: str = ROOM, worlds: int = 3, **settings):
    from stable_baselines3.common.vec_env import DummyVecEnv

    register()
    return DummyVecEnv([lambda: gymnasium.make(name, **SETTINGS, **settings)] * worlds)


def same(one, other) -> bool:
    if isinstance(one, dict):
        return set(one) == set(other) and all(same(one[key], other[key]) for key in one)
    return np.array_equal(one, other)


@pytest.mark.parametrize("settings", [{}, {"observation": "image", "size": 96}])
def test_it_is_theirs_to_the_byte(settings) -> None:
    """In the lab, which changes from one episode to the next; both ends of episodes included."""
    ours, other = native(LAB, **settings), theirs(LAB, **settings)
    assert ours.observation_space == other.observation_space and ours.action_space == other.action_space
    for env in (ours, other):
        env.seed(5)
    assert same(ours.reset(), other.reset())
    for actions in np.random.default_rng(0).integers(0, 3, (45, 3)):
        step, must = ours.step(actions), other.step(actions)
        assert all(same(one, two) for one, two in zip(step[:3], must[:3], strict=True)) and step[1].dtype == np.float32
        assert all(same(one, two) for one, two in zip(step[3], must[3], strict=True))
        assert all(same(one, two) for one, two in zip(ours.reset_infos, other.reset_infos, strict=True))
    assert [info["episode_index"] for info in ours.reset_infos] == [2, 2, 2]
    assert ours.get_attr("events") == other.get_attr("events") and np.array_equal(ours.render(), other.render())
    for env in (ours, other):
        env.set_options({"episode": 7})
    assert same(ours.reset(), other.reset()) and ours.get_attr("events") == other.get_attr("events")


@pytest.mark.parametrize("algorithm", ["PPO", "RecurrentPPO"])
def test_they_learn_the_same_in_both(algorithm: str) -> None:
    """VecMonitor counts the same episodes, and after two updates the weights have the same bytes."""
    from stable_baselines3.common.vec_env import VecMonitor

    models = []
    for make in (native, theirs):
        model = trainer(algorithm, VecMonitor(make()), 32)
        models.append(model.learn(192))
    ends = [[(end["l"], end["r"]) for end in model.ep_info_buffer] for model in models]
    assert ends[0] == ends[1] and [length for length, _ in ends[0]] == [20] * 9
    ours, other = (model.policy.state_dict() for model in models)
    assert models[0].num_timesteps == 192 and all(ours[name].equal(other[name]) for name in other)


def test_pictures_are_stacked_and_counted_by_gymnasium() -> None:
    from gymnasium.wrappers.vector import RecordEpisodeStatistics
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecFrameStack

    from curionav_cli.agents.sb3.vec_env import SB3VecEnv

    register()
    worlds = RecordEpisodeStatistics(gymnasium.make_vec(ROOM, num_envs=2, observation="image", **SETTINGS))
    model = PPO("CnnPolicy", VecFrameStack(SB3VecEnv(worlds), 4), n_steps=32, batch_size=32, n_epochs=1, device="cpu",
                policy_kwargs={"features_extractor_kwargs": {"features_dim": 8}})
    model.learn(64)
    assert model.observation_space.shape == (12, 64, 64) and [end["l"] for end in model.ep_info_buffer] == [20, 20]


def test_what_it_cannot_do_is_said() -> None:
    from curionav_cli.agents.sb3.vec_env import SB3VecEnv

    with pytest.raises(ValueError, match=r"have autoreset_mode=AutoresetMode.NEXT_STEP. Make them with"):
        SB3VecEnv(gymnasium.make_vec(ROOM, num_envs=2, autoreset_mode=AutoresetMode.NEXT_STEP))
    env = native()
    env.set_options([{"episode": 1}, {}, {}])
    with pytest.raises(ValueError, match="worlds in one batch are reset with the same options"):
        env.reset()
    with pytest.raises(ValueError, match="scene is one for all worlds in a batch; leave indices out"):
        env.set_attr("scene", None, indices=[0])
    with pytest.raises(AttributeError, match="worlds in a batch have no look_around of their own"):
        env.env_method("look_around")
    assert env.env_is_wrapped(gymnasium.Wrapper, indices=1) == [False]
    env.set_attr("observation", "image")
    assert env.get_attr("observation", indices=[0, 2]) == ["image", "image"]
    env.close()
