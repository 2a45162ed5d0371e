"""agent=sb3: algorithms of Stable-Baselines3 in our loop; a resumed run equals one in one go, to the byte."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from entry import Cli
from leftovers import repeatable

from curionav_cli import build
from curionav_cli.config.compose import composed
from curionav_cli.errors import ConfigError
from curionav_cli.storage.replay import Replay

pytestmark = [pytest.mark.clients, pytest.mark.usefixtures("blank_figures"),
              pytest.mark.filterwarnings("ignore::DeprecationWarning")]
ALGORITHMS = ("PPO", "A2C", "RecurrentPPO", "TRPO", "DQN", "QRDQN")
SMALL = "+agent.parameters.policy_kwargs={net_arch:[8],features_extractor_kwargs:{features_dim:8}}"
WORDS = ("env=small_room", "agent=sb3", "device=cpu", "loop.steps=12", "loop.iterations=2", "agent.unroll=6",
         "agent.conv_channels=[4,4]", "agent.rnd_batch=5", "agent.schedule_steps=40", SMALL)
MORE = {"RecurrentPPO": ("+agent.parameters.policy_kwargs.lstm_hidden_size=8",),
        "DQN": ("+agent.parameters.learning_starts=5", "+agent.parameters.target_update_interval=8",
                "+agent.parameters.batch_size=4"),
        "PPO": ("+agent.parameters.n_epochs=2", "+agent.parameters.batch_size=4")}


@pytest.fixture(autouse=True)
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("stable_baselines3")
    pytest.importorskip("sb3_contrib")
    monkeypatch.setenv("SB3_LOGDIR", str(tmp_path / "sb3"))  # of SB3's own loop; ours has no such folder


def words(algorithm: str, *more: str) -> list[str]:
    return [*WORDS, f"agent.algorithm={algorithm}", *MORE.get(algorithm.replace("QR", ""), ()), *more]


@pytest.mark.parametrize("reward", ["count", "rnd"])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_a_resumed_run_equals_one_in_one_go(cli: Cli, tmp_path: Path, algorithm: str, reward: str) -> None:
    for name, episodes in (("whole", 3), ("parts", 2)):
        answer = cli("explore", *words(algorithm, f"agent.reward={reward}"), f"loop.episodes={episodes}",
                     f"hydra.run.dir={name}")
        assert answer.code == 0, answer.error
    np.random.seed(7)  # noqa: NPY002
    assert cli("resume", "parts", "loop.episodes=3").code == 0
    whole, parts = tmp_path / "whole", tmp_path / "parts"
    for path in [path for path in whole.rglob("*") if path.parent.name in ("episodes", "000003")]:
        assert path.read_bytes() == (parts / path.relative_to(whole)).read_bytes(), path
    rows = [[json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()] for run in (whole, parts)]
    assert repeatable(rows[0]) == repeatable(rows[1])
    assert rows[0][-1]["updates"] > rows[0][0]["updates"] > 0 and rows[0][-1]["reward_mean"] > 0
    assert not (tmp_path / "sb3").exists(), "Stable-Baselines3 has made a folder for its log"


def an_agent(algorithm: str, *more: str):
    settings = composed("explore", *words(algorithm, *more))
    build.check(settings)
    return build.agent(settings, build.world(settings))


def test_the_rollout_buffer_holds_what_sb3_would_have_collected(an_episode) -> None:
    """Beside SB3's own collect_rollouts on an environment that plays the episode back with the same rewards."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.callbacks import CallbackList
    from stable_baselines3.common.vec_env import DummyVecEnv

    from curionav_cli.agents.sb3.agent import channels_first
    from curionav_cli.agents.sb3.model import Spaces, seeded

    agent, episode = an_agent("PPO", "agent.unroll=12"), an_episode(steps=12)
    rewards = np.linspace(0, 1, 12, dtype=np.float32)

    class Played(Spaces):
        def reset(self, *, seed=None, options=None):
            self.t = 0
            return channels_first(episode.image[0]), {}

        def step(self, action):
            self.t += 1
            return channels_first(episode.image[self.t]), float(rewards[self.t - 1]), False, self.t == 12, {}

    theirs = PPO("CnnPolicy", DummyVecEnv([Played]), n_steps=12, batch_size=12, device="cpu")
    theirs.policy = agent.model.policy
    _, callback = theirs._setup_learn(12, CallbackList([]))
    draws = np.random.default_rng(0)
    act = theirs.policy.forward

    def forward(*inputs):
        with seeded(draws):
            return act(*inputs)
    theirs.policy.forward = forward
    theirs.collect_rollouts(theirs.env, callback, theirs.rollout_buffer, 12)
    theirs.policy.forward = act

    agent.rng = np.random.default_rng(0)
    agent.begin()
    actions = [agent.act({"image": image}, {}) for image in episode.image[:12]]
    agent.fill(episode, rewards, agent.value_after(episode), 0)
    ours = agent.model.rollout_buffer
    assert actions == theirs.rollout_buffer.actions.flatten().tolist() and len(set(actions)) > 1
    for name in ("observations", "actions", "values", "log_probs", "rewards", "episode_starts", "advantages",
                 "returns"):
        assert np.array_equal(getattr(ours, name), getattr(theirs.rollout_buffer, name)), name


def test_the_replay_gives_each_transition_with_its_reward(an_episode) -> None:
    agent, replay = an_agent("DQN"), Replay([an_episode(steps=12, seed=seed) for seed in range(2)])
    agent.learn(replay, 1, lambda _: None)
    batch = agent.transitions.sample(64)
    images = [np.moveaxis(replay.episode(index).image, -1, 1) for index in range(2)]
    for seen, after, action, reward in zip(batch.observations.numpy(), batch.next_observations.numpy(),
                                           batch.actions.numpy(), batch.rewards.numpy(), strict=True):
        (index, t), = [(i, t) for i in range(2) for t in range(12) if np.array_equal(images[i][t], seen)]
        assert np.array_equal(images[index][t + 1], after) and action == replay.episode(index).action[t]
        assert reward == agent.transitions.rewards[index][t]
    assert batch.dones.sum() == 0 and batch.rewards.shape == batch.actions.shape == (64, 1)


def test_rewards_fade_where_nothing_is_new(an_episode) -> None:
    episode = an_episode(steps=12)
    count, rnd = an_agent("PPO").reward, an_agent("PPO", "agent.reward=rnd", "agent.rnd_lr=1e-2").reward
    assert count.rewards(episode).tolist() == [1.0] * 12 and np.allclose(count.rewards(episode), 2**-0.5)
    first = [rnd.rewards(episode).mean() * float(rnd.rms.total / rnd.rms.weight) ** 0.5 for _ in range(30)]
    assert first[-1] < 0.7 * first[0]


def test_it_is_evaluated_and_compared_like_the_others(cli: Cli, tmp_path: Path) -> None:
    assert cli("explore", *words("DQN"), "loop.episodes=1", "hydra.run.dir=run").code == 0
    answer = cli("evaluate", "run", "env=apartment_1", "loop.episodes=1", "hydra.run.dir=evaluated")
    assert answer.code == 0, answer.error
    weights = [tmp_path / run / "checkpoint" / "000001" / "weights.safetensors" for run in ("run", "evaluated")]
    assert weights[0].read_bytes() == weights[1].read_bytes()
    assert cli("explore", "-m", "agent=bounce", "seed=0", "env=small_room", "loop.steps=12", "loop.episodes=1",
               "hydra.sweep.dir=other").code == 0
    answer = cli("compare", "run", "other", "out=compared")
    assert answer.code == 0 and "sb3" in (tmp_path / "compared" / "runs.csv").read_text()


def test_parameters_are_those_of_the_algorithm() -> None:
    agent = an_agent("PPO", "+agent.parameters.ent_coef=0.25", "+agent.parameters.gamma=0.5")
    assert (agent.model.ent_coef, agent.model.gamma, agent.model.rollout_buffer.gamma) == (0.25, 0.5, 0.5)
    for more, said in ((("+agent.parameters.entropy=0.1",), "parameters.entropy is no setting of PPO here. It has: l"),
                       (("+agent.parameters.n_steps=5",), "agent.parameters.n_steps is no setting of PPO here"),
                       (("agent.parameters.batch_size=1",), "PPO refuses .*`batch_size` must be greater than 1"),
                       (("agent.unroll=1",), "agent.unroll: 1 is not between 2 and")):
        with pytest.raises(ConfigError, match=said):
            an_agent("PPO", *more)


def test_an_unroll_that_does_not_fit_and_no_learning(cli: Cli, tmp_path: Path) -> None:
    answer = cli("explore", *words("PPO", "agent.unroll=5"), "hydra.run.dir=run")
    assert answer.code == 2 and "agent.unroll=5 does not divide an episode of 12 steps" in answer.error
    plain = [word for word in words("PPO") if not word.startswith("loop.iterations")]
    assert cli("explore", *plain, "loop.iterations=0", "loop.episodes=1", "hydra.run.dir=run").code == 0
    assert yaml.safe_load((tmp_path / "run" / "config.yaml").read_text())["agent"]["algorithm"] == "PPO"


def test_without_sb3_one_line_says_what_to_install(cli: Cli, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "sb3_contrib", None)
    monkeypatch.setattr("curionav_cli.agents.sb3.find_spec", lambda name: None)
    answer = cli("explore", *words("TRPO"), "hydra.run.dir=run")
    assert answer.code == 2 and answer.error.strip() == (
        "agent=sb3 agent.algorithm=TRPO needs sb3_contrib, which is not installed: "
        ".venv/bin/pip install -c constraints.txt -e '.[sb3]'")
    assert not (tmp_path / "run" / "config.yaml").exists()
