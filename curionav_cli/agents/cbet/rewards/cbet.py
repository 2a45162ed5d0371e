"""C-BET: r = 1 / (N(s') + N(c)), counts of the image reached and of the change that led to it (Parisi et al., 2021).

As released: the tables are updated, then read; each environment has its own, and each is cleared at random, with a
small probability after each step. agent=cbet_lifelong has one table for all that is never cleared.
"""

from __future__ import annotations

import numpy as np
from torch import nn

from curionav_cli.agents.cbet.counts import Counts
from curionav_cli.agents.cbet.reward_monitor import RewardMonitor
from curionav_cli.agents.cbet.rewards.reward import Reward, RewardContext
from curionav_cli.agents.cbet.settings import Difference, Reset, Tables, View
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.agents.cbet.views import Ego, Panorama
from curionav_cli.agents.image_hash import ChangeKeys, StateKeys
from curionav_cli.world.scene.scene import Scene

CEILING = 0.5  # the reward of a step whose image and change are both new


def view_of(context: RewardContext) -> Panorama | Ego:
    """The view that agent.view names."""
    if context.hyper.view is View.ego:
        return Ego()
    assert isinstance(context.scene, Scene)  # see agents.cbet.privileged
    return Panorama(context.scene, context.engine, context.seed)


class CBET(Reward):
    """Counts of images and of changes of a view (views.py)."""

    def __init__(self, context: RewardContext, networks: nn.ModuleDict):
        super().__init__(context, networks)
        hyper, rng = context.hyper, np.random.default_rng(context.reward_seed)
        self.view = view_of(context)
        wrapped = hyper.difference is Difference.wrapped
        self.state_keys = StateKeys(hyper.key.value, hyper.key_bits, rng)
        self.change_keys = ChangeKeys(hyper.key.value, hyper.key_bits, self.view.views, wrapped, rng)
        tables = 1 if hyper.tables is Tables.shared else hyper.environments
        self.counts = {name: Counts(tables, hyper.reset is Reset.never) for name in ("states", "changes")}
        self.generators = [np.random.default_rng([context.reward_seed, e + 1]) for e in range(hyper.environments)]
        self.monitor = RewardMonitor(CEILING)

    def episode_bonus(self, transitions: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        """1 / (N(s') + N(c)) of each step (N,), and metrics of the counts."""
        states = self.state_keys(transitions.episode.image[transitions.reached])
        changes = self.change_keys(self.view(transitions), transitions.reached)
        last = len(transitions) - (not self.hyper.count_teleport)  # the step that ends in the respawn may not count
        cleared = self.cleared(len(transitions), transitions.environment)
        count = np.zeros((len(transitions), 2))  # of state and change
        for t in range(last):
            for n, (counts, key) in enumerate(zip(self.counts.values(), (states[t], changes[t]), strict=True)):
                count[t, n] = counts.add(transitions.environment, key)
                if cleared[t, n]:
                    counts.clear(transitions.environment)
        if self.hyper.reset is Reset.episode:
            for counts in self.counts.values():
                counts.clear(transitions.environment)
        bonus = np.append(1 / count[:last].sum(axis=1), np.zeros(len(transitions) - last))
        poses, keys = transitions.poses(), len(set(states[:-1]))
        self.monitor.update(poses, keys, bonus)
        return bonus, {
            "unique_states": len(set(states)) / len(states), "unique_changes": len(set(changes)) / len(changes),
            "unique_of_new_poses": keys / max(1, poses),
            "count_of_state": count[:last, 0].mean(), "count_of_change": count[:last, 1].mean(),
        }

    def cleared(self, steps: int, environment: int) -> np.ndarray:
        """Draw whether the table of states, and that of changes, is cleared after each step: (steps, 2) bool."""
        if self.hyper.reset is Reset.random:
            return self.generators[environment].random((steps, 2)) < self.hyper.reset_prob
        return np.zeros((steps, 2), bool)
