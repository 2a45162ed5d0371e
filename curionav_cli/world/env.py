"""The world through gymnasium: perfect motion, RGB and depth, one life of many episodes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from curionav_cli.world import motion
from curionav_cli.world.render import FAR, SIDE, Renderer
from curionav_cli.world.scene import Scene

Observation = dict[str, np.ndarray]
ACTIONS = spaces.Discrete(3)
OBSERVATIONS = spaces.Dict({
    "image": spaces.Box(0, 255, (SIDE, SIDE, 3), np.uint8),
    "depth": spaces.Box(0.0, FAR, (SIDE, SIDE), np.float32),
})


class NavigationEnv(gymnasium.Env[Any, Any]):
    """Actions: 0 forward 0.25 m, 1 left 10 degrees, 2 right 10 degrees. No reward, no end.

    Observation: image (64, 64, 3) uint8 RGB, depth (64, 64) float32 metres along the optical axis,
    at most 10. Info: pose (3,) float64 x y yaw, collided, episode, events (what changed in the world).
    `reset(seed=s)` starts a life at the scene's start (options={"episode": k}: at its k-th episode), a
    plain `reset()` goes back to the start for the next episode.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 as gymnasium declares it

    def __init__(self, scene: Scene, render_mode: str | None = None, engine: str = "numpy"):
        self.scene = scene
        self.render_mode = render_mode
        self.action_space, self.observation_space = spaces.Discrete(3), spaces.Dict(OBSERVATIONS.spaces)
        self._renderer = Renderer(scene, engine)
        self._life = 0
        self._episode = -1

    @property
    def engine(self) -> str:
        """What draws the pictures: numpy or numba."""
        return self._renderer.engine

    @property
    def now(self) -> Scene:
        """The scene of this episode: moved objects, light, and what can be reached among them."""
        return self._now

    def reset(self, *, seed: int | None = None,
              options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        if seed is not None:
            self._life, self._episode = seed, -1
        self._episode = (options or {}).get("episode", self._episode + 1)
        self._now, events = self.scene.at(self._episode, self._life)
        self._renderer = self._renderer.showing(self._now)
        self._x, self._y, self._heading = *self.scene.plan.start[:2], self.scene.start_heading
        self._seen: tuple[float, float, int] | None = None
        return self._observe(), self._info(False, events)

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        collided = False
        if action == motion.FORWARD:
            plan = self._now.plan
            self._x, self._y, collided = motion.forward(
                plan.visitable, plan.cell, self._x, self._y, self._heading, self.scene.collision)
        elif action == motion.LEFT:
            self._heading = (self._heading + 1) % motion.HEADINGS
        elif action == motion.RIGHT:
            self._heading = (self._heading - 1) % motion.HEADINGS
        else:
            raise ValueError(f"action {action!r} is none of 0 forward, 1 left, 2 right")
        return self._observe(), 0.0, False, False, self._info(collided)

    def render(self) -> np.ndarray:
        """The camera image of the current pose, (64, 64, 3) uint8."""
        return self._observe()["image"]

    def look(self, x, y, yaw) -> Observation:
        """What the camera would see from other poses, (n,) each: image (n, 64, 64, 3), depth (n, 64, 64)."""
        image, depth = self._renderer.look(x, y, yaw)
        return {"image": image, "depth": depth}

    def panorama(self, views: int = 4) -> Observation:
        """The view all around: image (views, 64, 64, 3), depth alike, the first as in the observation."""
        image, depth = self._renderer.panorama(self._x, self._y, self._heading, views)
        return {"image": image[0], "depth": depth[0]}

    def save(self, folder: Path) -> None:
        """Nothing: an episode's world follows from scene, seed and number, and it begins at the start."""

    def load(self, folder: Path) -> None:
        """Nothing was saved."""

    def _observe(self) -> Observation:
        pose = (self._x, self._y, self._heading)
        if pose != self._seen:  # a cancelled move shows the same picture
            image, depth = self._renderer.render(*pose)
            self._picture, self._seen = (image[0], depth[0]), pose
        image, depth = self._picture
        return {"image": image.copy(), "depth": depth.copy()}

    def _info(self, collided: bool, events: tuple[dict[str, Any], ...] = ()) -> dict[str, Any]:
        pose = np.array([self._x, self._y, motion.YAW[self._heading]])
        return {"pose": pose, "collided": collided, "episode": self._episode, "events": events}
