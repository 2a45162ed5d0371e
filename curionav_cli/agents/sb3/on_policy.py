"""PPO, A2C, TRPO and RecurrentPPO: `act` records what the policy gave, `learn` fills SB3's rollout buffer with it.

An episode of T steps gives T / n rollouts of n steps (agent.unroll), each followed by train(); the policy that acted is
that of the episode's beginning. At its last step the value of the image reached is added, as SB3 does where an episode
is cut off by time.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from curionav_cli.agents.meter import finite
from curionav_cli.agents.sb3 import settings
from curionav_cli.agents.sb3.agent import SB3Agent, channels_first
from curionav_cli.agents.sb3.model import seeded
from curionav_cli.errors import RunFailed
from curionav_cli.records import Episode
from curionav_cli.storage.replay import Replay


class Acted(NamedTuple):
    """A step: what the policy gave, and the LSTM's states before it (RecurrentPPO's RNNStates)."""

    action: Tensor
    value: Tensor
    log_prob: Tensor
    states: Any = None


class OnPolicy(SB3Agent):
    """On-policy algorithms of Stable-Baselines3; on a CPU the same seed gives the same bytes."""

    def __init__(self, own: settings.SB3, seed: int, device: str):
        super().__init__(own, seed, device, n_steps=own.unroll)

    def begin(self) -> None:
        """Start an episode from zero states."""
        self.acted: list[Acted] = []
        first = getattr(self.model, "_last_lstm_states", None)
        self.states = first and type(first)(*(tuple(map(torch.zeros_like, pair)) for pair in first))

    @torch.no_grad()
    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        """Draw an action from the policy, and record what learning needs."""
        self.model.policy.set_training_mode(False)
        image, before = self.observed(observation["image"][None]), self.states
        with seeded(self.rng):
            if before is None:
                action, value, log_prob = self.model.policy(image)
            else:
                action, value, log_prob, self.states = self.model.policy(image, before, self.start(not self.acted))
        self.acted.append(Acted(action, value, log_prob, before))
        return int(self.acted[-1].action)

    def start(self, first: bool) -> Tensor:
        """SB3's mark of a step that begins an episode, (1,)."""
        return torch.tensor([float(first)], device=self.device)

    def can_learn(self, replay: Replay) -> bool:
        """Whether the newest episode divides into rollouts; one that a fault cut short seldom does."""
        return len(replay.episode(-1)) % self.own.unroll == 0

    def learn(self, replay: Replay, iterations: int, tick: Callable[[int], None]) -> dict[str, float]:
        """Compute the rewards of the newest episode, then train on each of its rollouts; tick counts these.

        Raises RunFailed where a loss is not finite, or the episode is not the one just acted in.
        """
        if not iterations:
            return {}
        episode = replay.episode(-1)
        if len(episode) != len(self.acted):
            raise RunFailed("this agent learns on-policy: from the episode that it has just acted in, and no other.")
        rewards = self.reward.rewards(episode)
        self.count(len(episode))
        after = self.value_after(episode)
        for number, first in enumerate(range(0, len(episode), self.own.unroll), 1):
            self.fill(episode, rewards, after, first)
            with seeded(self.rng):
                self.model.train()
            tick(number)
        return finite(self.totals(rewards), self.model._n_updates, "agent.parameters.learning_rate")

    @torch.no_grad()
    def value_after(self, episode: Episode) -> Tensor:
        """The value of the last image, (1,), with the weights that acted."""
        image = self.observed(episode.image[-1:])
        if self.states is None:
            return self.model.policy.predict_values(image).flatten()
        return self.model.policy.predict_values(image, self.states.vf, self.start(False)).flatten()

    def fill(self, episode: Episode, rewards: np.ndarray, after: Tensor, first: int) -> None:
        """Fill the rollout buffer with the steps from `first` on, and compute its advantages."""
        buffer, steps = self.model.rollout_buffer, range(first, first + self.own.unroll)
        buffer.reset()
        ends = steps[-1] + 1 == len(episode)
        for t in steps:
            step, reward = self.acted[t], rewards[t]
            if t + 1 == len(episode):
                reward += self.model.gamma * float(after)
            recurrent = {} if step.states is None else {"lstm_states": step.states}
            buffer.add(channels_first(episode.image[t:t + 1]), step.action.cpu().numpy().reshape(1, 1),
                       np.array([reward]), np.array([t == 0]), step.value, step.log_prob, **recurrent)
        value = after if ends else self.acted[steps[-1] + 1].value
        buffer.compute_returns_and_advantage(last_values=value, dones=np.array([ends]))
