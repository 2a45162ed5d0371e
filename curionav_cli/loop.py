"""The one episodic loop (paper, section "Lifelong learning"): N steps, then K iterations, then return to dock.

Simulation and robot differ only in env.reset(): the robot is put back to its start, or returns to its dock. Learning
here and learning on a server differ only in `learn`. The loop depends on no environment and no agent.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

import gymnasium
import numpy as np

from curionav_cli.agents.agent import Agent
from curionav_cli.records import Episode, Prediction
from curionav_cli.remote.robot_sync import RobotSync
from curionav_cli.storage.replay import Replay


class Callbacks:
    """Callbacks of a run, for progress, metrics and checkpoints. These do nothing."""

    def began(self, index: int, info: dict[str, Any]) -> None:
        """Called after the reset for episode `index`, with its info."""

    def acted(self, step: int) -> None:
        """Called after each step of an episode; step counts from 1."""

    def learned(self, iteration: int) -> None:
        """Called after each of the K iterations; iteration counts from 1."""

    def predicted(self, index: int, prediction: Prediction) -> None:
        """Called with the agent's prediction of episode `index`, before it learns from it."""

    def episode_done(self, index: int, episode: Episode, metrics: dict[str, float]) -> None:
        """Called after episode `index` and the learning from it."""


class TrainCallbacks(Protocol):
    """Callbacks of offline training."""

    def learned(self, iteration: int) -> None:
        """Called after each iteration; it counts from 1 after each save."""

    def trained(self, iterations: int, metrics: dict[str, float]) -> None:
        """Called when it is time to save: iterations so far, and metrics of those since the last save."""


class Learn(Protocol):
    """What is done with an episode: learn from it here, or deliver it to a server."""

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        """Called after episode `index`; its metrics."""

    def docked(self, index: int) -> None:
        """Called at the dock before episode `index`, and after the last episode."""


def run_episodes(env: gymnasium.Env, agent: Agent, learn: Learn, *, episodes: int, steps: int, seed: int,
                 watch: Callbacks, first: int = 0, return_after_last: bool = False) -> None:
    """Run episodes `first` to `episodes` - 1 of `steps` steps each, and learn from each.

    return_after_last: reset the environment after the last episode too, so that a robot ends on its dock.
    """
    observation, info = env.reset(seed=seed, options={"episode": first})
    for index in range(first, episodes):
        watch.began(index, info)
        learn.docked(index)
        began = clocks()
        episode = run_episode(env, agent, observation, info, steps, watch)
        acted = clocks()
        metrics = learn(index, episode)
        learned = clocks()
        watch.episode_done(index, episode,
                           {**metrics, **spent("acting", began, acted), **spent("learning", acted, learned)})
        if index + 1 < episodes or return_after_last:
            observation, info = env.reset()
    if return_after_last:
        watch.began(episodes, info)
    learn.docked(episodes)


def clocks() -> tuple[float, float]:
    """Wall-clock seconds, and CPU seconds of all threads of this process."""
    return time.perf_counter(), time.process_time()


def spent(what: str, began: tuple[float, float], ended: tuple[float, float]) -> dict[str, float]:
    """Metrics seconds_`what` and cpu_seconds_`what`: the difference of two readings of the clocks."""
    wall, cpu = (after - before for before, after in zip(began, ended, strict=True))
    return {f"seconds_{what}": wall, f"cpu_seconds_{what}": cpu}


def run_episode(env: gymnasium.Env, agent: Agent, observation: dict[str, np.ndarray], info: dict[str, Any],
                steps: int, watch: Callbacks) -> Episode:
    """Run one episode of `steps` steps after a reset, or of fewer where the environment truncates it (battery low)."""
    image, action = np.empty((steps + 1, *observation["image"].shape), np.uint8), np.empty(steps, np.int64)
    image[0], infos, truncated = observation["image"], [info], False
    agent.begin()
    while len(infos) <= steps and not truncated:
        t = len(infos)
        action[t - 1] = agent.act(observation, info)
        observation, _, _, truncated, info = env.step(int(action[t - 1]))
        image[t] = observation["image"]
        infos.append(info)
        watch.acted(t)
    return recorded(image[:len(infos)], action[:len(infos) - 1], infos, env.get_wrapper_attr("events"))


def recorded(image: np.ndarray, action: np.ndarray, infos: list[dict[str, Any]],
             events: tuple[dict[str, Any], ...]) -> Episode:
    """The episode of images (T+1, 64, 64, 3), actions (T,), T+1 infos, and the changes in the world before it."""
    estimate = np.array([info["estimate"] for info in infos]) if "estimate" in infos[0] else None
    collided = np.array([info["collided"] for info in infos[1:]], bool)
    return Episode(image, action, np.array([info["pose"] for info in infos], np.float64), collided,
                   events, estimate, infos[0].get("dock"))


class NoLearning:
    """Neither learn nor store: the agent only acts."""

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        return {}

    def docked(self, index: int) -> None:
        """Do nothing."""


class LocalLearner(NoLearning):
    """Store the episode, then learn in this process: K iterations on all episodes so far."""

    def __init__(self, agent: Agent, replay: Replay, iterations: int, watch: Callbacks,
                 store: Callable[[int, Episode], None]):
        self.agent, self.replay, self.iterations = agent, replay, iterations
        self.watch, self.store = watch, store

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        self.store(index, episode)
        if not self.agent.learns:
            return self.agent.report()
        prediction = self.agent.predict(index, episode)
        if prediction:
            self.watch.predicted(index, prediction)
        self.replay.add(episode)
        able = self.agent.can_learn(self.replay)
        metrics = self.agent.learn(self.replay, self.iterations, self.watch.learned) if able else {}
        return {**self.agent.report(), **metrics, **(prediction.metrics() if prediction else {})}


class RemoteLearner:
    """Store the episode and put it into the outbox; at the dock `sync` delivers it and imports new weights."""

    def __init__(self, sync: RobotSync, store: Callable[[int, Episode], None]):
        self.sync, self.store = sync, store
        self.spent: dict[str, float] = {}

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        self.store(index, episode)
        self.sync.collect(index, episode)
        return {"weights_version": self.sync.version, **self.spent}

    def docked(self, index: int) -> None:
        began = clocks()
        self.sync.docked(index)
        self.spent = spent("docked", began, clocks())


def train(agent: Agent, replay: Replay, *, iterations: int, every: int, watch: TrainCallbacks, first: int = 0) -> None:
    """Offline training: iterations `first` to `iterations` on stored episodes; watch.trained saves after `every`."""
    done = first
    while done < iterations:
        began, until = time.perf_counter(), min(iterations, done - done % every + every)
        metrics = agent.learn(replay, until - done, watch.learned)
        done = until
        watch.trained(done, {**metrics, "seconds_learning": time.perf_counter() - began})
