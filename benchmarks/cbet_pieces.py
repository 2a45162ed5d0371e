"""C-BET piece by piece in one process, for turns.py: CPU-ms a frame of acting, rewards and learning.

    python benchmarks/cbet_pieces.py TREE       TREE: a checkout of this commit or of an older one

Answers each line of its input with an episode of 500 steps in the small room at scale=cpu, after some that are not
counted; the world's time is in none of the pieces.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

STEPS, FIRST = 500, 12  # of an episode; episodes until the policy has learned to move
BONUS = ("episode_bonus", "lived")  # what the reward of an episode is called, now and up to commit 7cd86ae


class NoCallbacks:
    def acted(self, step: int) -> None:
        """One more step."""


def timed(spent: dict[str, float], name: str, work: Callable[..., Any]) -> Callable[..., Any]:
    """The same function, its CPU-seconds added to spent[name]."""
    def counted(*words: Any, **named: Any) -> Any:
        began = time.process_time()
        result = work(*words, **named)
        spent[name] = spent.get(name, 0.0) + time.process_time() - began
        return result
    return counted


class Pieces:
    """An agent and its room, and the time that is spent on each piece."""

    def __init__(self) -> None:
        from learner_contenders import settings

        from curionav_cli import build

        chosen = settings(["env=small_room", "env.engine=numba", "agent=cbet", "scale=cpu", "device=cpu"])
        world = build.scene(chosen)
        self.env, self.agent, self.spent = build.env(chosen, world), build.agent(chosen, world), {}
        reward = self.agent.learner.reward
        bonus = next(name for name in BONUS if hasattr(reward, name))
        for name, owner, method in (("acting", self.agent, "act"), ("acting", self.agent, "begin"),
                                    ("reward", reward, bonus), ("whole", self.agent, "learn")):
            setattr(owner, method, timed(self.spent, name, getattr(owner, method)))
        self.start = self.env.reset(seed=0)

    def episode(self) -> dict[str, float]:
        """CPU-ms a frame."""
        from curionav_cli.loop import run_episode
        from curionav_cli.storage.replay import Replay

        self.spent.clear()
        replay = Replay()
        replay.add(run_episode(self.env, self.agent, *self.start, STEPS, NoCallbacks()))
        self.agent.learn(replay, 1, lambda done: None)
        self.start = self.env.reset()
        acting, reward = (1000 / STEPS * self.spent[name] for name in ("acting", "reward"))
        learning = 1000 / STEPS * self.spent["whole"] - reward
        return {"acting": acting, "learning": learning, "acting and learning": acting + learning, "reward": reward}


def main(tree: str) -> None:
    sys.path[:0] = [tree, f"{tree}/benchmarks"]
    warnings.simplefilter("ignore")
    import torch

    torch.set_num_threads(1)
    pieces = Pieces()
    for _ in range(FIRST):
        pieces.episode()
    print("{}", flush=True)
    for _ in sys.stdin:
        print(json.dumps(pieces.episode()), flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
