"""Stable-Baselines3 and sb3-contrib: PPO and PPO with an LSTM."""

from __future__ import annotations

import pytest

from curionav_cli.world.registration import SCENES

stable_baselines3 = pytest.importorskip("stable_baselines3", reason="needs the extra clients")
pytestmark = [pytest.mark.clients, pytest.mark.filterwarnings("ignore::DeprecationWarning")]
ROOM = "curionav/SmallRoom-v0"
TRAINERS = ("PPO", "RecurrentPPO")
ARRANGED = ("single", "DummyVecEnv", "SubprocVecEnv", "native")


def trainer(name: str, env, steps: int):
    """A small one that updates once after `steps` steps of each environment."""
    sb3_contrib = pytest.importorskip("sb3_contrib", reason="needs the extra clients")
    kwargs = {"net_arch": [8], "features_extractor_kwargs": {"cnn_output_dim": 8}}
    if name == "PPO":
        maker, policy = stable_baselines3.PPO, "MultiInputPolicy"
    else:
        maker, policy, kwargs = sb3_contrib.RecurrentPPO, "MultiInputLstmPolicy", {**kwargs, "lstm_hidden_size": 8}
    return maker(policy, env, n_steps=steps, batch_size=steps, n_epochs=1, seed=0, device="cpu", policy_kwargs=kwargs)


def many_worlds(settings: dict, arranged: str):
    """Two worlds: in this process, in processes of their own, or in our native vector environment."""
    import gymnasium
    from stable_baselines3.common import vec_env
    from stable_baselines3.common.env_util import make_vec_env

    from curionav_cli.agents.sb3.vec_env import SB3VecEnv

    name = settings.pop("id")
    if arranged == "native":
        return vec_env.VecMonitor(SB3VecEnv(gymnasium.make_vec(name, num_envs=2, **settings)))
    started = {"start_method": "spawn"} if arranged == "SubprocVecEnv" else {}
    return make_vec_env(name, n_envs=2, env_kwargs=settings, vec_env_cls=getattr(vec_env, arranged),
                        vec_env_kwargs=started)


@pytest.mark.filterwarnings("ignore:Your observation depth has an unconventional shape:UserWarning")
@pytest.mark.parametrize("name", SCENES)
def test_their_checker_finds_no_fault(made, name: str) -> None:
    """Its warnings are errors here, but for the one that depth is neither a picture nor a vector."""
    from stable_baselines3.common.env_checker import check_env

    check_env(made(name, render_mode="rgb_array"))


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("algorithm", TRAINERS)
def test_they_train_in_every_world(made, name: str, algorithm: str) -> None:
    model = trainer(algorithm, made(name, reward="coverage", max_episode_steps=40), 32)
    model.learn(64)
    assert model.num_timesteps == 64 and [info["l"] for info in model.ep_info_buffer] == [40]


@pytest.mark.parametrize("arranged", ARRANGED[1:])
@pytest.mark.parametrize("algorithm", TRAINERS)
def test_they_train_in_many_worlds(world, arranged: str, algorithm: str) -> None:
    env = many_worlds(world(ROOM, reward="coverage", max_episode_steps=60), arranged)
    model = trainer(algorithm, env, 64)
    model.learn(256)
    env.close()
    ends = list(model.ep_info_buffer)
    assert model.num_timesteps == 256 and [end["l"] for end in ends] == [60] * 4 and max(end["r"] for end in ends) > 1


def test_pictures_alone_are_stacked_and_monitored(world) -> None:
    """CnnPolicy with VecFrameStack, Monitor and Gymnasium's statistics in one."""
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
    env = made(ROOM, observation="image", action="continuous", reward="coverage", max_episode_steps=20)
    kwargs = {"net_arch": [8], "features_extractor_kwargs": {"features_dim": 8}}
    model = stable_baselines3.SAC("CnnPolicy", env, buffer_size=50, learning_starts=10, batch_size=8, seed=0,
                                  device="cpu", policy_kwargs=kwargs)
    model.learn(24)
    assert model.num_timesteps == 24 and model._n_updates > 0 and [info["l"] for info in model.ep_info_buffer] == [20]


def test_an_evaluation_comes_to_an_end(made) -> None:
    from stable_baselines3.common.evaluation import evaluate_policy

    model = trainer("PPO", made(ROOM), 32)
    rewards, lengths = evaluate_policy(model, made(ROOM, reward="count"), n_eval_episodes=1, deterministic=False,
                                       return_episode_rewards=True, warn=False)
    assert lengths == [500] and 0 < rewards[0] < 500


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("arranged", ARRANGED)
@pytest.mark.parametrize("algorithm", TRAINERS)
@pytest.mark.parametrize("name", SCENES)
def test_2048_steps_in_every_world(world, made, name: str, algorithm: str, arranged: str) -> None:
    """Four episodes of 500 steps, an update after each 512 steps of a world, and an actor that has changed."""
    env = many_worlds(world(name, reward="coverage"), arranged) if arranged != "single" else \
        made(name, reward="coverage")
    model = trainer(algorithm, env, 512)
    before = {key: value.clone() for key, value in model.policy.state_dict().items()}
    model.learn(2048)
    ends = [(info["l"], info["r"] > 1) for info in model.ep_info_buffer]
    assert model.num_timesteps == 2048 and ends == [(500, True)] * 4
    after = model.policy.state_dict()
    assert not any(after[key].equal(before[key]) for key in after if key.startswith("action_net."))
    model.env.close()
