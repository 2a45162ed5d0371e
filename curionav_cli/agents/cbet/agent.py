"""C-BET in the shared loop: the robot lives one episode after another, E environments take turns in it.

The released method runs E environments side by side, all from the same start in our comparisons, with weights that
do not change within a round. E consecutive episodes with frozen weights are exactly that: episode k belongs to
environment k mod E, which has count tables and a random stream for forgetting of its own; the LSTM is zeroed where
an episode starts. Each episode leaves N / T unrolls. As soon as B of them wait, they are learned from once, whatever
the loop's K is (0 means no learning). With N = 500, T = 100, B = 20 and E = 4 that is once a round.
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
from curionav_cli.agents.cbet.rewards import REWARDS
from curionav_cli.agents.cbet.rewards.reward import RewardContext
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.cbet.unrolls import Acted, Unroll, cut, together
from curionav_cli.agents.device import keep_freed_memory, repeatable, resolve_device
from curionav_cli.agents.meter import Meter, finite
from curionav_cli.errors import RunFailed
from curionav_cli.records import Episode
from curionav_cli.storage.replay import Replay
from curionav_cli.world.scene.scene import Scene


class CBET(Agent):
    """agent=cbet and agent=cbet_lifelong, with the reward that agent.reward names.

    It is handed the world for what is privileged: panoramas, true cells. Same seed, same bytes on a CPU.
    """

    learns = True
    on_policy = True

    def __init__(self, hyper: cbet_settings.CBET, seed: int, device: str, world: Scene, engine: str):
        super().__init__(seed)
        self.hyper, self.device, self.plan = hyper, resolve_device(device), world.plan
        repeatable(self.device)
        keep_freed_memory()
        weights, numbers = (int(n) for n in self.rng.integers(2**62, size=2))
        networks = build_networks(hyper, torch.Generator().manual_seed(weights), self.device)
        reward = REWARDS[hyper.reward.value](RewardContext(hyper, world, engine, seed, numbers), networks.reward)
        self.learner = Learner(hyper, networks, reward)
        self.waiting: list[Unroll] = []
        self.seen = np.zeros((hyper.environments, world.plan.visitable.size), bool)
        self.episode = 0
        self.begin()

    def begin(self) -> None:
        """Forget the episode: a zero memory."""
        self.actor = actor(self.learner.networks.policy)
        self.acted = Acted()

    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        """Sample the policy, and note what its learning will need."""
        self.episode = int(info["episode_index"])
        if len(self.acted.log_policy) % self.hyper.unroll == 0:
            self.acted.memory.append(self.actor.memory())
        log_policy = log_softmax(self.actor.step(observation["image"]).tolist())
        policy = [math.exp(number) for number in log_policy]
        action = min(bisect_right(list(accumulate(policy)), self.rng.random()), len(policy) - 1)
        self.acted.log_policy.append(log_policy[action])
        self.acted.entropy.append(-sum(map(mul, policy, log_policy)))
        return action

    def learn(self, replay: Replay, iterations: int, tick: Callable[[int], None]) -> dict[str, float]:
        """Reward the newest episode, then update while B unrolls wait; tick counts the updates of this call.

        Raises RunFailed where a loss or a gradient is not finite.
        """
        if not iterations:
            return {}
        life = Transitions(self.own(replay.episode(-1)), self.episode, self.episode % self.hyper.environments)
        bonus, watch = self.learner.reward.episode_bonus(life)
        self.waiting += cut(life, self.acted, bonus, self.hyper.unroll)
        meter, done = Meter(), 0
        while len(self.waiting) >= self.hyper.batch_size:
            batch = together(self.waiting[:self.hyper.batch_size], self.device)
            del self.waiting[:self.hyper.batch_size]
            meter.add(self.learner.update(batch))
            tick(done := done + 1)
        learned = finite(meter.read(), self.learner.updates, "agent.lr")
        return {**learned, **watch, **self.account(life)}

    def account(self, life: Transitions) -> dict[str, float]:
        """What it did and what it cost: updates and the frames they read, both since the run began."""
        row, column = self.plan.cells(*life.episode.pose[1:, :2].T)
        self.seen[life.environment, row * self.plan.visitable.shape[1] + column] = True
        updates = self.learner.updates
        return {
            "policy_entropy": float(np.mean(self.acted.entropy)),
            "most_cells_of_one_environment": int((self.seen & self.plan.visitable.ravel()).sum(axis=1).max()),
            "updates": updates, "frames_replayed": updates * self.hyper.batch_size * self.hyper.unroll,
            "unrolls_waiting": len(self.waiting),
        }

    def own(self, episode: Episode) -> Episode:
        """The episode, if it is the one that was just acted. Raises RunFailed if not."""
        if len(episode) != len(self.acted.log_policy):
            raise RunFailed("this agent learns on-policy: from the episode that it has just lived, and no other.")
        return episode

    def save(self, folder: Path) -> None:
        super().save(folder)
        save_learner(self.learner, folder)
        save_memory(self.learner, self.waiting, self.seen, folder)

    def load(self, folder: Path) -> None:
        super().load(folder)
        load_learner(self.learner, folder)
        self.waiting, self.seen = load_memory(self.learner, folder)
        self.begin()


def log_softmax(logits: list[float]) -> list[float]:
    """Log probabilities; what is not finite stays so, for the learner to find."""
    shift = max(logits)
    shift += math.log(sum(math.exp(number - shift) for number in logits))
    return [number - shift for number in logits]
