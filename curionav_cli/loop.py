"""The one episodic loop (paper, section "Lifelong learning"): N steps, then K iterations, then home.

Simulation and robot differ only in env.reset(): respawn, or drive home and dock. `learn` is the other
strategy: here, or there, on a server. The loop knows neither which environment nor which agent it runs.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, Protocol

import gymnasium
import numpy as np

from curionav_cli.agents.agent import Agent
from curionav_cli.records import Episode, Foresight
from curionav_cli.remote.robot_sync import RobotSync
from curionav_cli.storage.replay import Replay


class Callbacks:
    """Called as a run goes on, for progress, metrics and checkpoints. These do nothing."""

    def began(self, index: int, info: dict[str, Any]) -> None:
        """The environment is reset for episode `index`; info is that of the reset."""

    def acted(self, step: int) -> None:
        """One more step of the running episode is done."""

    def learned(self, iteration: int) -> None:
        """One more of the K iterations is done."""

    def predicted(self, index: int, foresight: Foresight) -> None:
        """What the agent expected of episode `index`, before it learned from it."""

    def episode_done(self, index: int, episode: Episode, metrics: dict[str, float]) -> None:
        """Episode `index` and the learning after it are done."""


class TrainCallbacks(Protocol):
    """Who looks on where nobody lives."""

    def learned(self, iteration: int) -> None:
        """One more iteration since the last save is done."""

    def trained(self, iterations: int, metrics: dict[str, float]) -> None:
        """So many iterations are done in all; the metrics are of those since the last save."""


class Learn(Protocol):
    """What becomes of an episode: learned from here, or delivered."""

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        """Episode `index` has ended; metrics of what was done with it."""

    def docked(self, index: int) -> None:
        """The robot stands at its dock, before episode `index`, and after the last."""


def run_episodes(env: gymnasium.Env, agent: Agent, learn: Learn, *, episodes: int, steps: int, seed: int,
                 watch: Callbacks, first: int = 0, return_after_last: bool = False) -> None:
    """Episodes `first` to `episodes`, `steps` steps each; learn(index, episode) gives metrics.

    return_after_last: the environment is also reset after the last episode, so that a robot ends on its dock.
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
    """Seconds on the wall, and of all this process's threads on CPUs."""
    return time.perf_counter(), time.process_time()


def spent(what: str, began: tuple[float, float], ended: tuple[float, float]) -> dict[str, float]:
    """Both kinds of seconds between two readings of the clocks."""
    wall, cpu = (after - before for before, after in zip(began, ended, strict=True))
    return {f"seconds_{what}": wall, f"cpu_seconds_{what}": cpu}


def run_episode(env: gymnasium.Env, agent: Agent, observation: dict[str, np.ndarray], info: dict[str, Any],
                steps: int, watch: Callbacks) -> Episode:
    """Live `steps` steps from where the robot stands, or fewer where the environment ends it (a battery runs low)."""
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
    """An episode of images (T+1, 64, 64, 3), actions (T,), T+1 infos, and what had changed in the world before it."""
    estimate = np.array([info["estimate"] for info in infos]) if "estimate" in infos[0] else None
    collided = np.array([info["collided"] for info in infos[1:]], bool)
    return Episode(image, action, np.array([info["pose"] for info in infos], np.float64), collided,
                   events, estimate, infos[0].get("dock"))


class NoLearning:
    """The agent acts, and nothing is stored."""

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        return {}

    def docked(self, index: int) -> None:
        """Nothing is to be fetched."""


class LocalLearner(NoLearning):
    """Store the episode, then K iterations on all that was lived so far, in this process."""

    def __init__(self, agent: Agent, replay: Replay, iterations: int, watch: Callbacks,
                 store: Callable[[int, Episode], None]):
        self.agent, self.replay, self.iterations = agent, replay, iterations
        self.watch, self.store = watch, store

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        self.store(index, episode)
        if not self.agent.learns:
            return self.agent.report()
        foresight = self.agent.predict(index, episode)
        if foresight:
            self.watch.predicted(index, foresight)
        self.replay.add(episode)
        metrics = self.agent.learn(self.replay, self.iterations, self.watch.learned)
        return {**self.agent.report(), **metrics, **(foresight.metrics() if foresight else {})}


class RemoteLearner:
    """Store the episode and put it into the outbox; at the dock a courier delivers it and brings weights."""

    def __init__(self, courier: RobotSync, store: Callable[[int, Episode], None]):
        self.courier, self.store = courier, store
        self.spent: dict[str, float] = {}

    def __call__(self, index: int, episode: Episode) -> dict[str, float]:
        self.store(index, episode)
        self.courier.collect(index, episode)
        return {"weights_version": self.courier.version, **self.spent}

    def docked(self, index: int) -> None:
        began = clocks()
        self.courier.docked(index)
        self.spent = spent("docked", began, clocks())


def train(agent: Agent, replay: Replay, *, iterations: int, every: int, watch: TrainCallbacks, first: int = 0) -> None:
    """Iterations `first` to `iterations` on what is stored, without a world; the watcher saves after `every`."""
    done = first
    while done < iterations:
        began, until = time.perf_counter(), min(iterations, done - done % every + every)
        metrics = agent.learn(replay, until - done, watch.learned)
        done = until
        watch.trained(done, {**metrics, "seconds_learning": time.perf_counter() - began})
