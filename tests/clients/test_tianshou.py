"""tianshou: its vector environments, collector and DQN."""

from __future__ import annotations

import pytest

from curionav_cli.world.registration import SCENES

pytestmark = [pytest.mark.clients, pytest.mark.filterwarnings("ignore")]  # of its dependencies, at import


@pytest.mark.parametrize("name", SCENES)
def test_it_collects_and_trains_in_every_world(made, name: str) -> None:
    """Episodes are as long as the environment says, and an update changes the network."""
    pytest.importorskip("tianshou")
    import torch
    from tianshou.algorithm import DQN
    from tianshou.algorithm.modelfree.dqn import DiscreteQLearningPolicy
    from tianshou.algorithm.optim import AdamOptimizerFactory
    from tianshou.data import Collector, VectorReplayBuffer
    from tianshou.env import DummyVectorEnv
    from tianshou.utils.torch_utils import policy_within_training_step

    class Values(torch.nn.Module):
        """Values of images (B, 64, 64, 3), through every eighth pixel."""

        def __init__(self) -> None:
            super().__init__()
            self.layer = torch.nn.Linear(8 * 8 * 3, 3)

        def forward(self, obs, state=None, info=None):
            return self.layer(torch.as_tensor(obs[:, ::8, ::8]).flatten(1) / 255.0), state

    settings = {"observation": "image", "reward": "count", "max_episode_steps": 10}
    env, worlds = made(name, **settings), DummyVectorEnv([lambda: made(name, **settings)] * 2)
    policy = DiscreteQLearningPolicy(model=Values(), action_space=env.action_space,
                                     observation_space=env.observation_space, eps_training=1.0)
    algorithm = DQN(policy=policy, optim=AdamOptimizerFactory(lr=1e-2))
    collector = Collector(algorithm, worlds, VectorReplayBuffer(100, 2), exploration_noise=True)
    collector.reset()
    before = policy.model.layer.weight.clone()
    with policy_within_training_step(policy):
        stats = collector.collect(n_episode=4)
        algorithm.update(collector.buffer, sample_size=16)
    assert stats.n_collected_steps == 40 and stats.lens.tolist() == [10] * 4 and stats.returns.min() > 1
    assert not torch.equal(before, policy.model.layer.weight)
    assert collector.buffer.obs[0].shape == (64, 64, 3)
    worlds.close()
