"""The contract of an agent: `act`, and what else it needs of the methods below. What the loop (loop.py) calls:

    for index in range(episodes):
        observation, info = env.reset()               # respawn at the start, or return to dock
        agent.begin()                                 # forget what belongs to one episode
        for _ in range(N):
            action = agent.act(observation, info)     # 0 forward 0.25 m, 1 left 10 degrees, 2 right 10 degrees
            observation, _, _, _, info = env.step(action)
        agent.predict(index, episode)                 # if agent.learns: open-loop predictions, for the figures
        replay.add(episode)                           # if agent.learns
        metrics = agent.learn(replay, K, tick)        # if agent.learns: K iterations on all episodes so far
        agent.probe(probe)                            # every so often, if results.probe_every: for the figures
        agent.save(folder)                            # a checkpoint; load(folder) restores it to the bit

Offline training (curionav train) calls `learn`, `save` and `load` alone. With learner=remote the robot's agent imports,
before an episode, the weights that the server's agent exported after learning.

The smallest agent is a class with `act`; registry.py says how it gets a name on the command line. Two rules hold for
all: the same seed gives the same actions and weights on one machine, so draw from `self.rng` or from generators that
`save` writes; and what is saved or exported is JSON or safetensors, nothing pickled.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.constants import Stream
from curionav_cli.decisions import EACH_STEP, Every
from curionav_cli.files import read_json
from curionav_cli.probe import Probe, Probed
from curionav_cli.records import Episode, Prediction
from curionav_cli.storage.replay import Replay


class Agent(ABC):
    """Base class of all agents: acts, keeps no memory and learns nothing, unless a method says otherwise.

    learns: `learn` does something; without it the loop keeps no replay and calls neither `learn` nor `predict`.
    sees: it acts by images or depth although it does not learn; the docking trial draws them for it.
    on_policy: it learns only from the episode that it has just acted in, so that offline training is refused.
    counts: its reward counts over all episodes, so that the replay must hold them all.
    has_model: it has a world model, which `probe` measures.
    every: how often it chooses, at each step unless it says otherwise (action repeat, options); the replay keeps the
    frames at which it does.
    device: where it computes, for the record.
    rng: its own generator, seeded by the run's seed; `save` and `load` keep its state.
    """

    learns = False
    sees = False
    on_policy = False
    counts = False
    has_model = False
    every: Every = EACH_STEP
    device: Any = "cpu"

    def __init__(self, seed: int):
        self.rng = np.random.default_rng([seed, Stream.agent])

    def begin(self) -> None:
        """Forget the last episode; called before the first `act` of each."""

    @abstractmethod
    def act(self, observation: dict[str, np.ndarray], info: dict[str, Any]) -> int:
        """Choose the next action: 0 forward, 1 left, 2 right (constants.py).

        observation: image (64, 64, 3) uint8 RGB, depth (64, 64) float32 metres.
        info: pose (x, y, yaw) in metres and radians, collided (the last forward action was cut short or cancelled),
        episode_index (counted over the whole run, also after it was resumed); of a robot that drifts also estimate and
        lidar (robot/env.py).
        """

    def predict(self, index: int, episode: Episode) -> Prediction | None:
        """Predict episode `index` before learning from it; None for an agent without a model, or too short an episode.

        Changes nothing in the agent: random numbers come from a generator of seed and index (Stream.predictions).
        """
        return None

    def probe(self, probe: Probe) -> Probed | None:
        """Measure the world model on the building's fixed probe, for results alone; None for an agent without one.

        Changes nothing in the agent, draws none of its random numbers, and keeps nothing of the probe.
        """
        return None

    def can_learn(self, replay: Replay) -> bool:
        """Whether the replay holds what `learn` needs: a real robot's episodes may end after a few steps."""
        return True

    def learn(self, replay: Replay, iterations: int, tick: Callable[[int], None]) -> dict[str, float]:
        """Learn for K iterations on the replay; returns the metrics of this call for metrics.jsonl.

        tick: to be called with 1, 2, ... after each iteration. No iterations change nothing and return {}.
        Raises ConfigError where the episodes do not fit the settings, RunFailed where a loss is not finite.
        """
        return {}

    def export_weights(self) -> bytes:
        """Return the weights that acting needs as a safetensors file; b"" if acting needs none."""
        return b""

    def import_weights(self, raw: bytes) -> None:
        """Act with the weights that `export_weights` returned.

        Raises WeightsRefused, and changes nothing, where they do not fit this agent, are broken or not finite.
        """

    def load_weights(self, folder: Path) -> None:
        """Take what an agent of the same settings learned from its checkpoint, to act and predict in any world.

        Random state and all that belongs to one world (counts, maps) stay this agent's own.
        Raises RunFolderError where a file is missing or broken, or belongs to an agent of other settings.
        """

    def report(self) -> dict[str, float]:
        """Metrics of the episode that has just ended, for metrics.jsonl; none by default."""
        return {}

    def save(self, folder: Path) -> None:
        """Write all that `load` needs into an existing empty folder."""
        (folder / "rng.json").write_text(json.dumps(self.rng.bit_generator.state))

    def load(self, folder: Path) -> None:
        """Restore what `save` wrote, random state included.

        Raises RunFolderError where a file is missing or broken, or belongs to an agent of other settings.
        """
        self.rng.bit_generator.state = read_json(folder / "rng.json")
