"""C-BET: 1 / (N(s') + N(c)), counts of the picture reached and of the change that led to it (Parisi et al., 2021).

As released: the tables are updated, then read; each environment has its own, and each is forgotten at random, with
a small probability after each step. With one table for all that is never forgotten it explores for a lifetime.
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

CEILING = 0.5  # of a step whose picture and change are both new


class CBET(Reward):
    """view: of which the change is taken."""

    def __init__(self, kit: RewardContext, networks: nn.ModuleDict):
        super().__init__(kit, networks)
        hyper, rng = kit.hyper, np.random.default_rng(kit.numbers)
        pano = hyper.view is View.pano
        self.view = Panorama(kit.world, kit.engine, kit.seed) if pano else Ego()
        wrapped = hyper.difference is Difference.wrapped
        self.state_keys = StateKeys(hyper.key.value, hyper.key_bits, rng)
        self.change_keys = ChangeKeys(hyper.key.value, hyper.key_bits, self.view.views, wrapped, rng)
        tables = 1 if hyper.tables is Tables.shared else hyper.environments
        self.counts = {"states": Counts(tables), "changes": Counts(tables)}
        self.generators = [np.random.default_rng([kit.numbers, e + 1]) for e in range(hyper.environments)]
        self.alarm = RewardMonitor(CEILING)

    def episode_bonus(self, life: Transitions) -> tuple[np.ndarray, dict[str, float]]:
        states = self.state_keys(life.episode.image[life.reached])
        changes = self.change_keys(self.view(life), life.reached)
        last = len(life) - (not self.hyper.count_teleport)  # the step that ends in the respawn may not count
        forgotten = self.forgotten(len(life), life.environment)
        met = np.zeros((len(life), 2))
        for t in range(last):
            for n, (counts, key) in enumerate(zip(self.counts.values(), (states[t], changes[t]), strict=True)):
                met[t, n] = counts.add(life.environment, key)
                if forgotten[t, n]:
                    counts.clear(life.environment)
        if self.hyper.reset is Reset.episode:
            for counts in self.counts.values():
                counts.clear(life.environment)
        bonus = np.append(1 / met[:last].sum(axis=1), np.zeros(len(life) - last))
        poses, keys = life.poses(), len(set(states[:-1]))
        self.alarm.look(poses, keys, bonus)
        return bonus, {
            "unique_states": len(set(states)) / len(life), "unique_changes": len(set(changes)) / len(life),
            "unique_of_new_poses": keys / max(1, poses),
            "count_of_state": met[:last, 0].mean(), "count_of_change": met[:last, 1].mean(),
        }

    def forgotten(self, steps: int, environment: int) -> np.ndarray:
        """(steps, 2) bool: is the table of states, that of changes cleared by chance after this step?"""
        if self.hyper.reset is Reset.random:
            return self.generators[environment].random((steps, 2)) < self.hyper.reset_prob
        return np.zeros((steps, 2), bool)
