"""A scene as a Gymnasium environment: perfect motion, RGB and depth, runs of many episodes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from curionav_cli.constants import ACTIONS, FORWARD, HEADINGS, IMAGE_CHANNELS, IMAGE_SIDE, LEFT, RIGHT
from curionav_cli.world import motion
from curionav_cli.world.pictures import Pictures
from curionav_cli.world.render.renderer import FAR, Renderer
from curionav_cli.world.resets import EpisodeCounter, check_render_mode, episode_of, seed_of
from curionav_cli.world.reward import Reward
from curionav_cli.world.scene.scene import Scene

Observation = dict[str, np.ndarray]
OBSERVATIONS = ("dict", "image")
METADATA: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}


def actions() -> spaces.Discrete:
    """A new action space: 0 forward 0.25 m, 1 left 10 degrees, 2 right 10 degrees."""
    return spaces.Discrete(len(ACTIONS))


def observations(kind: str = "dict", side: int = IMAGE_SIDE) -> spaces.Dict | spaces.Box:
    """A new observation space: image (S, S, 3) uint8 alone, or a dict with it and depth (S, S) float32 metres.

    Raises ValueError for another kind.
    """
    image = spaces.Box(0, 255, (side, side, IMAGE_CHANNELS), np.uint8)
    if kind not in OBSERVATIONS:
        raise ValueError(f"observation must be one of {', '.join(OBSERVATIONS)}, not {kind!r}.")
    return image if kind == "image" else spaces.Dict({
        "image": image, "depth": spaces.Box(0.0, FAR, (side, side), np.float32)})


def seen(observation: Observation, kind: str) -> Any:
    """An observation of this kind: the dict itself, or its image."""
    return observation if kind == "dict" else observation["image"]


class NavigationEnv(gymnasium.Env[Any, Any]):
    """A Gymnasium environment of one scene. Actions: 0 forward 0.25 m, 1 left 10 degrees, 2 right 10 degrees.

    A step never ends the episode. It raises ValueError for another action, ResetNeeded before the first reset.
    Observation: image (S, S, 3) uint8 RGB, depth (S, S) float32 metres along the optical axis, at most 10; S = side.
    Info, of one structure in every step: pose (3,) float64 x y yaw in metres and radians, collided () bool,
    episode_index int64. `events`, a tuple of dicts: what changed in the world before this episode (objects, light).
    `reset(seed=s)` starts run s at the scene's start (options={"episode": k}: at its k-th episode), a plain `reset()`
    goes back to the start for the next episode; reset_mode="continue": see resets.EpisodeCounter. reward: none,
    coverage or count, the last two privileged (reward.Reward). observation="image": the image alone.
    """

    metadata = METADATA

    def __init__(self, scene: Scene, render_mode: str | None = None, engine: str = "numpy", reward: str = "none",
                 reset_mode: str = "restart", observation: str = "dict", side: int = IMAGE_SIDE):
        check_render_mode(render_mode, METADATA["render_modes"])
        self.scene = scene
        self.render_mode = render_mode
        self.observation = observation
        self.action_space, self.observation_space = self.actions(), observations(observation, side)
        self.reward = Reward(reward)
        self.events: tuple[dict[str, Any], ...] = ()
        self._renderer, self._pictures = Renderer(scene, engine, side=side), Pictures(side=side)
        self.counter = EpisodeCounter(reset_mode)

    def actions(self) -> spaces.Space[Any]:
        """A new action space."""
        return actions()

    @property
    def engine(self) -> str:
        """The rendering engine: numpy or numba."""
        return self._renderer.engine

    @property
    def now(self) -> Scene:
        """The scene of this episode, with moved objects and light. Raises ResetNeeded before the first reset."""
        self.counter.require()
        return self._now

    def reset(self, *, seed: int | None = None,
              options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        seed, episode = seed_of(seed), episode_of(options)
        super().reset(seed=seed)
        self.counter.reset(seed, episode)
        self._now, self.events = self.scene.at(self.counter.episode, self.counter.seed)
        self._renderer = self._renderer.showing(self._now)
        self._x, self._y = self.scene.plan.start[:2]
        self._face_start()
        self._pictures.forget()
        self.reward.reset(self._now.plan, self._x, self._y)
        return seen(self._observe(), self.observation), self._info(False)

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        collided = self._move(action)
        earned = self.reward.step(self._x, self._y)
        return seen(self._observe(), self.observation), earned, False, False, self._info(collided)

    def _face_start(self) -> None:
        """Turn to the start's heading."""
        self._heading = self.scene.start_heading

    def _move(self, action: int) -> bool:
        """Carry out an action; whether it was cut short or cancelled by an obstacle."""
        plan, collided = self.now.plan, False
        if action == FORWARD:
            before = (self._x, self._y)
            self._x, self._y, collided = motion.forward(
                plan.visitable, plan.cell, *before, self._heading, self.scene.collision)
            if (self._x, self._y) != before:
                self._pictures.forget()
        elif action == LEFT:
            self._heading = (self._heading + 1) % HEADINGS
        elif action == RIGHT:
            self._heading = (self._heading - 1) % HEADINGS
        else:
            raise ValueError(f"action {action!r} is none of 0 forward, 1 left, 2 right")
        return collided

    def render(self) -> np.ndarray:
        """The camera image of the current pose, (S, S, 3) uint8."""
        self.counter.require()
        return self._observe()["image"]

    def look(self, x, y, yaw) -> Observation:
        """Render other poses, (n,) each, yaw in radians: image (n, S, S, 3), depth (n, S, S). Nothing moves."""
        image, depth = self._renderer.look(x, y, yaw)
        return {"image": image, "depth": depth}

    def panorama(self, views: int = 4) -> Observation:
        """Render `views` directions all around, the first ahead: image (views, S, S, 3), depth (views, S, S)."""
        self.counter.require()
        image, depth = self._renderer.panorama(self._x, self._y, self._heading, views)
        return {"image": image[0], "depth": depth[0]}

    def save(self, folder: Path) -> None:
        """Write nothing: an episode's scene follows from scene file, seed and episode number."""

    def load(self, folder: Path) -> None:
        """Read nothing; see `save`."""

    def _observe(self) -> Observation:
        if self._pictures.missing([0], [self._heading]):
            image, depth = self._renderer.render(self._x, self._y, self._heading)
            self._pictures.keep(0, self._heading, image[0], depth[0])
        return self._pictures.one(0, self._heading)

    def _info(self, collided: bool) -> dict[str, Any]:
        return step_info((self._x, self._y, motion.YAW[self._heading]), collided, self.counter.episode)


def step_info(pose: Sequence[float], collided: bool, episode: int) -> dict[str, Any]:
    """The info of a step as arrays and numpy numbers, which can be batched: pose (3,), collided (), episode_index."""
    return {"pose": np.array(pose), "collided": np.array(collided, bool), "episode_index": np.int64(episode)}
