"""C-BET in the one loop: E environments take turns, one an episode.

The released method runs E environments side by side, all from the same start in our comparisons, with weights that do
not change within a round. E consecutive episodes with frozen weights are exactly that: episode k belongs to environment
k mod E, which has its own count tables and its own random stream for clearing them; the LSTM starts each episode from
zeros. An episode of N steps gives N / T unrolls of T. As soon as B of them wait, there is one update on them, whatever
the loop's K is (0: no learning). With N = 500, T = 100, B = 20 and E = 4 that is one update a round.

The intrinsic reward comes from rewards/ (cbet.py is the paper's), used in learner.py.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from itertools import accumulate
from operator import mul
from pathlib import Path
from typing import Any

import numpy as np
import torch

from curionav_cli.agents.agent import Agent
from curionav_cli.agents.cbet import settings as cbet_settings
from curionav_cli.agents.cbet.acting import actor
from curionav_cli.agents.cbet.checkpoint import load_learner, load_memory, save_learner, save_memory
from curionav_cli.agents.cbet.learner import Learner, build_networks
from curionav_cli.agents.cbet.rewards.choose import reward_class
from curionav_cli.agents.cbet.rewards.reward import RewardContext
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.cbet.unrolls import ActingRecord, Unroll, split_episode, stack_unrolls
from curionav_cli.agents.device import keep_freed_memory, repeatable, resolve_device
from curionav_cli.agents.meter import Meter, finite
from curionav_cli.agents.weights import load_weights
from curionav_cli.errors import RunFailed
from curionav_cli.records import Episode
from curionav_cli.storage.replay import Replay
from curionav_cli.world.real_floor import RealFloor
from curionav_cli.world.scene.scene import Scene


class CBET(Agent):
    """agent=cbet and agent=cbet_lifelong, with the reward that agent.reward names.

    scene: for what is privileged, panoramas and true cells. On a CPU the same seed gives the same bytes.
    """

    learns = True
    on_policy = True

    def __init__(self, hyper: cbet_settings.CBET, seed: int, device: str, scene: Scene | RealFloor, engine: str):
        super().__init__(seed)
        self.hyper, self.device, self.plan = hyper, resolve_device(device), scene.plan
        repeatable(self.device)
        keep_freed_memory(kept=2**29, mapped_from=2**25)
        weights_seed, reward_seed = (int(n) for n in self.rng.integers(2**62, size=2))
        networks = build_networks(hyper, torch.Generator().manual_seed(weights_seed), self.device)
        reward = reward_class(hyper.reward)(RewardContext(hyper, scene, engine, seed, reward_seed), networks.reward)
        self.learner = Learner(hyper, networks, reward)
        self.waiting: list[Unroll] = []
        self.visited = np.zeros((hyper.environments, scene.plan.visitable.size), bool)
        self.episode = 0
        self.begin()

    def begin(self) -> None:
        """Start an episode from a zero memory, with the weights of now."""
        self.actor = actor(self.learner.networks.policy)
        self.acted = ActingRecord()

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        """Draw an action from the policy, and record what learning needs: log mu, and the memory before each unroll."""
        self.episode = int(info["episode_index"])
        if len(self.acted.log_policy) % self.hyper.unroll == 0:
            self.acted.memory.append(self.actor.memory())
        log_policy = log_softmax(self.actor.step(observation["image"]).tolist())
        policy = [math.exp(number) for number in log_policy]
        action = min(bisect_right(list(accumulate(policy)), self.rng.random()), len(policy) - 1)
        self.acted.log_policy.append(log_policy[action])
        self.acted.entropy.append(-sum(map(mul, policy, log_policy)))
        return action

    def can_learn(self, replay: Replay) -> bool:
        """Whether the newest episode divides into unrolls; one that a fault cut short seldom does."""
        return len(replay.episode(-1)) % self.hyper.unroll == 0

    def learn(self, replay: Replay, iterations: int, tick: Callable[[int], None]) -> dict[str, float]:
        """Compute the rewards of the newest episode, then update while B unrolls wait; tick counts these updates.

        Raises RunFailed where a loss or a gradient is not finite, or the episode is not the one just acted in.
        """
        if not iterations:
            return {}
        episode = self.on_policy_episode(replay)
        transitions = Transitions(episode, self.episode, self.episode % self.hyper.environments)
        bonus, reward_metrics = self.learner.reward.episode_bonus(transitions)
        self.waiting += split_episode(transitions, self.acted, bonus, self.hyper.unroll)
        meter, done = Meter(), 0
        while len(self.waiting) >= self.hyper.batch_size:
            batch = stack_unrolls(self.waiting[:self.hyper.batch_size], self.device)
            del self.waiting[:self.hyper.batch_size]
            meter.add(self.learner.update(batch))
            tick(done := done + 1)
        learned = finite(meter.read(), self.learner.updates, "agent.lr")
        return {**learned, **reward_metrics, **self.totals(transitions)}

    def totals(self, transitions: Transitions) -> dict[str, float]:
        """Metrics of the policy and of the run so far: coverage of an environment, updates, frames they read."""
        row, column = self.plan.cells(*transitions.episode.pose[1:, :2].T)
        self.visited[transitions.environment, row * self.plan.visitable.shape[1] + column] = True
        updates = self.learner.updates
        return {
            "policy_entropy": float(np.mean(self.acted.entropy)),
            "most_cells_of_one_environment": int((self.visited & self.plan.visitable.ravel()).sum(axis=1).max()),
            "updates": updates, "frames_replayed": updates * self.hyper.batch_size * self.hyper.unroll,
            "unrolls_waiting": len(self.waiting),
        }

    def on_policy_episode(self, replay: Replay) -> Episode:
        """Return the newest episode. Raises RunFailed where it is not the one just acted in."""
        episode = replay.episode(-1)
        if len(episode) != len(self.acted.log_policy):
            raise RunFailed("this agent learns on-policy: from the episode that it has just acted in, and no other.")
        return episode

    def save(self, folder: Path) -> None:
        """Write the files that checkpoint.py lists, and rng.json."""
        super().save(folder)
        save_learner(self.learner, folder)
        save_memory(self.learner, self.waiting, self.visited, folder)

    def load(self, folder: Path) -> None:
        """Restore what `save` wrote. Raises RunFolderError as `load_learner` and `load_memory` do."""
        super().load(folder)
        load_learner(self.learner, folder)
        self.waiting, self.visited = load_memory(self.learner, folder)
        self.begin()

    def load_weights(self, folder: Path) -> None:
        """Take all networks from a checkpoint; counts begin anew. Raises RunFolderError as load_weights does."""
        load_weights(self.learner.networks, folder)
        self.begin()


def log_softmax(logits: list[float]) -> list[float]:
    """Log probabilities (A,) of logits (A,); not-finite numbers stay so, and the learner reports them."""
    shift = max(logits)
    shift += math.log(sum(math.exp(number - shift) for number in logits))
    return [number - shift for number in logits]
