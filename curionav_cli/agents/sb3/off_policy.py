"""DQN and QRDQN: they draw transitions from our replay, which holds all episodes, and learn K times after each.

The end of an episode is no end for the values: the run goes on from the start, and SB3 treats an episode that is cut
off by time alike.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.buffers import ReplayBufferSamples

from curionav_cli.agents.meter import finite
from curionav_cli.agents.sb3 import settings
from curionav_cli.agents.sb3.agent import SB3Agent, channels_first
from curionav_cli.agents.sb3.model import seeded
from curionav_cli.constants import ACTIONS, IMAGE_SHAPE
from curionav_cli.storage.replay import Replay


class Transitions:
    """What SB3's train() takes for its replay buffer: our replay, with the rewards of every episode."""

    def __init__(self, rng: np.random.Generator, device: torch.device):
        self.rng, self.device, self.replay = rng, device, Replay()
        self.rewards: list[np.ndarray] = []  # (T,) of each episode

    def sample(self, batch_size: int, env: object = None) -> ReplayBufferSamples:
        """Draw B transitions, each equally likely."""
        which, start = self.replay.draw(batch_size, 2, self.rng)
        images = np.empty((batch_size, 2, *IMAGE_SHAPE), np.uint8)
        self.replay.frames(which, start, images)
        action = self.replay.moves(which, start, 2)["action"][:, 1:]
        reward = np.array([[self.rewards[e][s]] for e, s in zip(which.tolist(), start.tolist())], np.float32)
        pairs, ends = channels_first(images), np.zeros_like(reward)
        return ReplayBufferSamples(*(torch.from_numpy(np.ascontiguousarray(part)).to(self.device)
                                     for part in (pairs[:, 0], action, pairs[:, 1], ends, reward)))


class OffPolicy(SB3Agent):
    """Off-policy algorithms of Stable-Baselines3; on a CPU the same seed gives the same bytes."""

    def __init__(self, own: settings.SB3, seed: int, device: str):
        super().__init__(own, seed, device, buffer_size=1)
        self.model.replay_buffer = self.transitions = Transitions(self.rng, self.device)

    @torch.no_grad()
    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        """The action of the highest value; at random before learning_starts, and as often as exploration demands."""
        model = self.model
        often = model.exploration_schedule(model._current_progress_remaining)
        if self.rng.random() < often or model.num_timesteps < model.learning_starts:
            return int(self.rng.choice(ACTIONS))
        model.policy.set_training_mode(False)
        return int(model.policy._predict(self.observed(observation["image"][None]), deterministic=True))

    def learn(self, replay: Replay, iterations: int, tick: Callable[[int], None]) -> dict[str, float]:
        """Compute the rewards of new episodes, then take K steps, each on a batch; none before learning_starts.

        Raises RunFailed where a loss is not finite.
        """
        if not iterations:
            return {}
        known, model = self.transitions, self.model
        known.replay = replay
        while len(known.rewards) < len(replay):
            episode = replay.episode(len(known.rewards))
            known.rewards.append(self.reward.rewards(episode))
            self.count(len(episode))
            self.update_target(len(episode))
        for number in range(1, iterations + 1 if model.num_timesteps > model.learning_starts else 1):
            with seeded(self.rng):
                model.train(1, model.batch_size)
            tick(number)
        return finite(self.totals(known.rewards[-1]), model._n_updates, "agent.parameters.learning_rate")

    def update_target(self, steps: int) -> None:
        """Let SB3 count steps: it copies weights to the target network after every so many of them."""
        for _ in range(steps):
            self.model._on_step()

    def memory(self) -> dict[str, np.ndarray]:
        """Also the rewards of all steps, the number of steps of each episode, and SB3's count of steps."""
        rewards = self.transitions.rewards
        return {**super().memory(), "rewards": np.concatenate([np.zeros(0, np.float32), *rewards]),
                "lengths": np.array([len(part) for part in rewards], np.int64),
                "calls": np.array(self.model._n_calls)}

    def restore_memory(self, arrays: dict[str, np.ndarray]) -> None:
        """Take the arrays that `memory` gave."""
        super().restore_memory(arrays)
        ends = np.cumsum(arrays["lengths"])[:-1]
        self.transitions.rewards = np.split(arrays["rewards"], ends) if len(arrays["lengths"]) else []
        self.model._n_calls = int(arrays["calls"])
