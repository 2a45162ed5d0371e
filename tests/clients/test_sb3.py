"""Stable-Baselines3 and sb3-contrib: PPO and PPO with an LSTM."""

from __future__ import annotations

import pytest

from curionav_cli.world.registration import SCENES

pytestmark = [pytest.mark.clients, pytest.mark.filterwarnings("ignore::DeprecationWarning")]
ROOM = "curionav/SmallRoom-v0"
TRAINERS = ("PPO", "RecurrentPPO")


def trainer(name: str, env, steps: int):
    """A small one that updates once after `steps` steps of each environment."""
    stable_baselines3, sb3_contrib = pytest.importorskip("stable_baselines3"), pytest.importorskip("sb3_contrib")
    kwargs = {"net_arch": [8], "features_extractor_kwargs": {"cnn_output_dim": 8}}
    if name == "PPO":
        maker, policy = stable_baselines3.PPO, "MultiInputPolicy"
    else:
        maker, policy, kwargs = sb3_contrib.RecurrentPPO, "MultiInputLstmPolicy", {**kwargs, "lstm_hidden_size": 8}
    return maker(policy, env, n_steps=steps, batch_size=steps, n_epochs=1, seed=0, device="cpu", policy_kwargs=kwargs)


@pytest.mark.filterwarnings("ignore:Your observation depth has an unconventional shape:UserWarning")
@pytest.mark.parametrize("name", SCENES)
def test_their_checker_finds_no_fault(made, name: str) -> None:
    """Its warnings are errors here, but for the one that depth is neither a picture nor a vector."""
    pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.env_checker import check_env

    check_env(made(name, render_mode="rgb_array"))


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("algorithm", TRAINERS)
def test_they_train_in_every_world(made, name: str, algorithm: str) -> None:
    model = trainer(algorithm, made(name, reward="coverage", max_episode_steps=40), 32)
    model.learn(64)
    assert model.num_timesteps == 64 and [info["l"] for info in model.ep_info_buffer] == [40]


@pytest.mark.parametrize("workers", ["DummyVecEnv", "SubprocVecEnv"])
@pytest.mark.parametrize("algorithm", TRAINERS)
def test_they_train_in_many_worlds(world, workers: str, algorithm: str) -> None:
    pytest.importorskip("stable_baselines3")
    from stable_baselines3.common import vec_env
    from stable_baselines3.common.env_util import make_vec_env

    settings = world(ROOM, reward="coverage", max_episode_steps=60)
    started = {"start_method": "spawn"} if workers == "SubprocVecEnv" else {}
    env = make_vec_env(settings.pop("id"), n_envs=2, env_kwargs=settings, vec_env_cls=getattr(vec_env, workers),
                       vec_env_kwargs=started)
    model = trainer(algorithm, env, 64)
    model.learn(256)
    env.close()
    ends = list(model.ep_info_buffer)
    assert model.num_timesteps == 256 and [end["l"] for end in ends] == [60] * 4 and max(end["r"] for end in ends) > 1


def test_pictures_alone_are_stacked_and_monitored(world) -> None:
    """CnnPolicy with VecFrameStack, Monitor and Gymnasium's statistics in one."""
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    import gymnasium
    from gymnasium.wrappers import RecordEpisodeStatistics
    from stable_baselines3.common.monitor import Monitor
    from stable_baselines3.common.vec_env import DummyVecEnv, VecFrameStack

    settings = world(ROOM, observation="image", reward="coverage", max_episode_steps=40)
    env = VecFrameStack(DummyVecEnv([lambda: Monitor(RecordEpisodeStatistics(gymnasium.make(**settings)))]), 4)
    model = stable_baselines3.PPO("CnnPolicy", env, n_steps=64, batch_size=64, n_epochs=1, device="cpu",
                                  policy_kwargs={"features_extractor_kwargs": {"features_dim": 8}})
    model.learn(64)
    assert model.observation_space.shape == (12, 64, 64) and [info["l"] for info in model.ep_info_buffer] == [40]


def test_continuous_actions_are_learned(made) -> None:
    stable_baselines3 = pytest.importorskip("stable_baselines3")
    env = made(ROOM, observation="image", action="continuous", reward="coverage", max_episode_steps=20)
    kwargs = {"net_arch": [8], "features_extractor_kwargs": {"features_dim": 8}}
    model = stable_baselines3.SAC("CnnPolicy", env, buffer_size=50, learning_starts=10, batch_size=8, seed=0,
                                  device="cpu", policy_kwargs=kwargs)
    model.learn(24)
    assert model.num_timesteps == 24 and model._n_updates > 0 and [info["l"] for info in model.ep_info_buffer] == [20]


def test_an_evaluation_comes_to_an_end(made) -> None:
    pytest.importorskip("stable_baselines3")
    from stable_baselines3.common.evaluation import evaluate_policy

    model = trainer("PPO", made(ROOM), 32)
    rewards, lengths = evaluate_policy(model, made(ROOM, reward="count"), n_eval_episodes=1, deterministic=False,
                                       return_episode_rewards=True, warn=False)
    assert lengths == [500] and 0 < rewards[0] < 500
