"""A C-BET small enough for quick tests, in the small room, and episodes of given actions."""

from pathlib import Path

import numpy as np
import pytest
import torch
from omegaconf import OmegaConf

from curionav_cli.agents.cbet import settings as cbet_settings
from curionav_cli.agents.cbet.agent import CBET
from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.config.schema_source import writable
from curionav_cli.loop import run_episode
from curionav_cli.records import Episode
from curionav_cli.storage.replay import Replay
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

CONF = Path(__file__).parents[3] / "conf"
TINY = {"conv_channels": [4, 4, 4], "dense_units": [8], "lstm_units": 6, "lstm_layers": 2, "unroll": 5,
        "batch_size": 4, "environments": 2, "key_bits": 64}


@pytest.fixture(autouse=True)
def one_thread():
    torch.set_num_threads(1)


@pytest.fixture(scope="session")
def small_room():
    return Scene.from_dict(*plain("small_room"))


@pytest.fixture
def hyper():
    """hyper(scale, agent, **changes): the shipped settings, cpu.yaml laid over paper.yaml, the agent's over both."""
    def make(scale="cpu", agent="cbet", **changes):
        layers = [OmegaConf.load(CONF / "scale" / "cbet" / f"{name}.yaml")
                  for name in ("paper", "cpu")[:1 if scale == "paper" else 2]]
        layers.append(OmegaConf.load(CONF / "agent" / f"{agent}.yaml"))
        for layer in layers:
            layer.pop("defaults", None)
        schema = cbet_settings.CBETLifelong if agent == "cbet_lifelong" else cbet_settings.CBET
        return OmegaConf.to_object(OmegaConf.merge(writable(schema), *layers, changes))
    return make


@pytest.fixture
def tiny(hyper):
    """tiny(agent, **changes): settings for a learner of a few hundred weights."""
    return lambda agent="cbet", **changes: hyper("cpu", agent, **{**TINY, **changes})


@pytest.fixture
def agent(tiny, small_room):
    """agent(seed=0, name="cbet", **changes): a tiny agent in the small room."""
    return lambda seed=0, name="cbet", **changes: CBET(tiny(name, **changes), seed, "cpu", small_room, "numpy")


class NoProgress:
    def acted(self, step):
        """One more step."""


class Room:
    """The small room, and a replay that grows: runs episode after episode with an agent."""

    def __init__(self, world, steps=10, first=0, seed=0):
        self.env, self.steps, self.replay = NavigationEnv(world), steps, Replay()
        self.start = self.env.reset(seed=seed, options={"episode": first})

    def episode(self, agent):
        if self.start is None:
            self.start = self.env.reset()
        episode = run_episode(self.env, agent, *self.start, self.steps, NoProgress())
        self.start = None
        self.replay.add(episode)
        return episode

    def run(self, agent, episodes):
        """Episodes with learning after each; their metrics."""
        rows = []
        for _ in range(episodes):
            self.episode(agent)
            rows.append(agent.learn(self.replay, 1, lambda done: None))
        return rows


@pytest.fixture
def room(small_room):
    """room(steps=10, first=0, seed=0): the small room, with episodes of so many steps."""
    return lambda **words: Room(small_room, **words)


@pytest.fixture
def walk(small_room):
    """walk(actions, index=0, environment=0): the transitions of these actions in the small room."""
    def make(actions, index=0, environment=0):
        env = NavigationEnv(small_room)
        observation, info = env.reset(seed=0)
        image, pose, collided = [observation["image"]], [info["pose"]], []
        for action in actions:
            observation, _, _, _, info = env.step(action)
            image.append(observation["image"])
            pose.append(info["pose"])
            collided.append(info["collided"])
        episode = Episode(np.array(image), np.array(actions), np.array(pose), np.array(collided))
        return Transitions(episode, index, environment)
    return make
