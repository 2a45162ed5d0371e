"""The contract: what an agent must be able to do. The loop (loop.py), as an agent sees it:

    for each episode:
        agent.begin()                                # forget what belongs to one episode
        observation, info = where it stands
        for N steps:
            action = agent.act(observation, info)    # 0 forward 0.25 m, 1 left 10 deg, 2 right 10 deg
            observation, info = env.step(action)
        agent.predict(index, episode)                # what it would have expected of it, for the figures
        metrics = agent.learn(replay, iterations)    # K iterations on all that was lived so far
        agent.save(folder)                           # load(folder) restores it to the bit

Where a server learns, the robot's agent adopts before an episode what the server's agent shares after one.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.constants import Stream
from curionav_cli.files import read_json
from curionav_cli.records import Episode, Prediction
from curionav_cli.storage.replay import Replay


class Agent(ABC):
    """An agent without memory and without learning; the others override what they need.

    learns: whether `learn` does anything (the loop keeps no replay in memory otherwise).
    on_policy: it learns from what it has just lived and from nothing else, so not from stored episodes.
    every: steps for which it holds an action; the replay keeps the frames that it acts on.
    """

    learns = False
    on_policy = False
    every = 1
    device: Any = "cpu"  # where it computes

    def __init__(self, seed: int):
        self.rng = np.random.default_rng([seed, Stream.agent])

    def begin(self) -> None:
        """An episode starts."""

    @abstractmethod
    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        """The next action.

        observation: image (64, 64, 3) uint8, depth (64, 64) float32 metres.
        info: pose (x, y, yaw), collided (did the last action fall short), episode_index.
        """

    def predict(self, index: int, episode: Episode) -> Prediction | None:
        """What it expects of episode `index` before it learns from it; None if it expects nothing.

        Changes nothing in the agent: what it draws comes from a generator of this episode alone.
        """
        return None

    def learn(self, replay: Replay, iterations: int, tick: Callable[[int], None]) -> dict[str, float]:
        """K iterations on the replay; tick(i) after each. Metrics for metrics.jsonl."""
        return {}

    def export_weights(self) -> bytes:
        """The weights that acting needs, as a safetensors file: a robot `adopt`s what a server has learned."""
        return b""

    def import_weights(self, raw: bytes) -> None:
        """Act with weights that `share` gave. Raises WeightsRefused, and changes nothing, where it cannot."""

    def report(self) -> dict[str, float]:
        """Metrics of the episode that has just ended, for metrics.jsonl; none by default."""
        return {}

    def save(self, folder: Path) -> None:
        """Write all that `load` needs into an existing empty folder."""
        (folder / "rng.json").write_text(json.dumps(self.rng.bit_generator.state))

    def load(self, folder: Path) -> None:
        """Become what was saved, random state included."""
        self.rng.bit_generator.state = read_json(folder / "rng.json")
