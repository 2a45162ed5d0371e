"""Many worlds that step together: one call, and one batched drawing of all pictures that changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from curionav_cli.world import motion
from curionav_cli.world.env import ACTIONS, OBSERVATIONS, Observation
from curionav_cli.world.render import SIDE, Renderer
from curionav_cli.world.scene import Scene

Info = dict[str, Any]


class NavigationVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """E NavigationEnvs in one: world i does what a single one with the same seed does, to the byte.

    Info holds arrays: pose (E, 3), collided (E,), episode (E,), events (E,) of tuples, and `_pose` and so
    on, where they are known. A world ends only if max_episode_steps says so, and then goes home in the
    same step (AutoresetMode.SAME_STEP): every action is carried out, so every transition is real; what was
    seen last is in final_obs and final_info. `reset(options={"reset_mask": mask})` sends some worlds home.
    """

    metadata = {  # noqa: RUF012 as gymnasium declares it
        "render_modes": ["rgb_array"], "render_fps": 10, "autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(self, scene: Scene, num_envs: int = 1, render_mode: str | None = None, engine: str = "numpy",
                 max_episode_steps: int | None = None):
        self.scene, self.num_envs, self.render_mode = scene, num_envs, render_mode
        self.max_episode_steps = max_episode_steps
        self.single_action_space, self.single_observation_space = ACTIONS, OBSERVATIONS
        self.action_space = batch_space(ACTIONS, num_envs)
        self.observation_space = batch_space(OBSERVATIONS, num_envs)
        self._now = [scene] * num_envs
        self._renderers = [Renderer(scene, engine)] * num_envs
        self._brightness = np.ones(num_envs)
        self._x, self._y = np.zeros(num_envs), np.zeros(num_envs)
        self._heading, self._episode, self._steps, self._life = np.zeros((4, num_envs), np.int64)
        self._episode -= 1
        self._image = np.empty((num_envs, SIDE, SIDE, 3), np.uint8)
        self._depth = np.empty((num_envs, SIDE, SIDE), np.float32)

    @property
    def engine(self) -> str:
        """What draws the pictures: numpy or numba."""
        return self._renderers[0].engine

    @property
    def now(self) -> list[Scene]:
        """The scene of each world's episode."""
        return list(self._now)

    def reset(self, *, seed: int | list[int | None] | None = None,
              options: dict[str, Any] | None = None) -> tuple[Observation, Info]:
        """seed s gives the worlds the lives s, s + 1, ...; a list names them; None sends them home."""
        seeds = [int(seed) + i for i in range(self.num_envs)] if isinstance(seed, int | np.integer) else seed
        options = options or {}
        which = np.flatnonzero(options.get("reset_mask", np.ones(self.num_envs, bool)))
        for world in which.tolist():
            life = None if seeds is None else seeds[world]
            if life is not None:
                self._life[world], self._episode[world] = life, -1
        events = self._go_home(which, options.get("episode"))
        self._see(which)
        return self._observation(), self._info(np.zeros(self.num_envs, bool), events, which)

    def step(self, actions: np.ndarray) -> tuple[Observation, np.ndarray, np.ndarray, np.ndarray, Info]:
        actions = np.asarray(actions)
        if actions.shape != (self.num_envs,) or not ((actions >= 0) & (actions < 3)).all():
            raise ValueError(f"actions {actions!r} are not {self.num_envs} of 0 forward, 1 left, 2 right")
        turn = (actions == motion.LEFT).astype(np.int64) - (actions == motion.RIGHT)
        self._heading = (self._heading + turn) % motion.HEADINGS
        changed, collided = turn != 0, np.zeros(self.num_envs, bool)
        for world in np.flatnonzero(actions == motion.FORWARD).tolist():
            changed[world], collided[world] = self._forward(world)
        self._see(np.flatnonzero(changed))
        self._steps += 1
        info = self._info(collided)
        over = np.full(self.num_envs, False)
        if self.max_episode_steps is not None:
            over = self._steps >= self.max_episode_steps
            if over.any():
                info = self._start_again(np.flatnonzero(over), info)
        return self._observation(), np.zeros(self.num_envs), np.zeros(self.num_envs, bool), over, info

    def render(self) -> tuple[np.ndarray, ...]:
        """The camera image of each world, (64, 64, 3) uint8."""
        return tuple(self._image.copy())

    def look(self, x, y, yaw) -> Observation:
        """What the camera would see from one other pose in each world, (E,) each; nothing moves."""
        return self._drawn(np.arange(self.num_envs), Renderer.look, *map(np.asarray, (x, y, yaw)))

    def panorama(self, views: int = 4) -> Observation:
        """The view all around: image (E, views, 64, 64, 3), depth alike, the first as in the observation."""
        return self._drawn(np.arange(self.num_envs), Renderer.panorama, self._x, self._y, self._heading, views=views)

    def _forward(self, world: int) -> tuple[bool, bool]:
        """Did the pose change, did it collide?"""
        plan, before = self._now[world].plan, (float(self._x[world]), float(self._y[world]))
        x, y, collided = motion.forward(plan.visitable, plan.cell, *before, int(self._heading[world]),
                                        self.scene.collision)
        self._x[world], self._y[world] = x, y
        return (x, y) != before, collided

    def _go_home(self, which: np.ndarray, episode: int | None = None) -> np.ndarray:
        """Worlds `which` begin their next episode, or this one; what changed in them (E,)."""
        events = np.full(self.num_envs, None, object)
        for world in which.tolist():
            self._episode[world] = self._episode[world] + 1 if episode is None else episode
            now, events[world] = self.scene.at(int(self._episode[world]), int(self._life[world]))
            self._now[world], self._brightness[world] = now, now.brightness
            self._renderers[world] = self._renderers[world].showing(now)
        self._x[which], self._y[which] = self.scene.plan.start[:2]
        self._heading[which], self._steps[which] = self.scene.start_heading, 0
        return events

    def _start_again(self, which: np.ndarray, last: Info) -> Info:
        """The info of a step after which worlds `which` went home."""
        final = np.full(self.num_envs, None, object)
        for world in which.tolist():
            final[world] = {"image": self._image[world].copy(), "depth": self._depth[world].copy()}
        ended = np.isin(np.arange(self.num_envs), which)
        known = {key: ended for key in last if key.startswith("_")}
        went = self._go_home(which)
        self._see(which)
        events = np.where(ended, went, last["events"])
        info = self._info(last["collided"] & ~ended, events)
        return {**info, "final_obs": final, "_final_obs": ended, "final_info": {**last, **known},
                "_final_info": ended}

    def _see(self, which: np.ndarray) -> None:
        if len(which):
            seen = self._drawn(which, Renderer.render, self._x[which], self._y[which], self._heading[which])
            self._image[which], self._depth[which] = seen["image"], seen["depth"]

    def _drawn(self, which: np.ndarray, draw: Callable[..., tuple[np.ndarray, np.ndarray]], *poses: np.ndarray,
               **how: Any) -> Observation:
        """Pictures of worlds `which`, one drawing for all worlds in which the same things stand alike."""
        groups: dict[int, list[int]] = {}
        for place, world in enumerate(which.tolist()):
            groups.setdefault(id(self._renderers[world].view), []).append(place)
        pieces = [draw(self._renderers[which[group[0]]], *(part[group] for part in poses),
                       brightness=self._brightness[which[group]], **how) for group in groups.values()]
        if len(pieces) == 1:
            return {"image": pieces[0][0], "depth": pieces[0][1]}
        back = np.argsort(np.concatenate([np.array(group) for group in groups.values()]))
        image, depth = (np.concatenate(part)[back] for part in zip(*pieces, strict=True))
        return {"image": image, "depth": depth}

    def _observation(self) -> Observation:
        return {"image": self._image.copy(), "depth": self._depth.copy()}

    def _info(self, collided: np.ndarray, events: np.ndarray | None = None,
              which: np.ndarray | slice = slice(None)) -> Info:
        if events is None:
            events = np.full(self.num_envs, None, object)
            events.fill(())
        known = np.zeros(self.num_envs, bool)
        known[which] = True
        pose = np.stack([self._x, self._y, motion.YAW[self._heading]], axis=1)
        info = {"pose": pose, "collided": collided, "episode": self._episode.copy(), "events": events}
        return info | {f"_{key}": known for key in info}


def make(scene: str, num_envs: int = 1, render_mode: str | None = None, max_episode_steps: int | None = None,
         **settings: Any) -> NavigationVectorEnv:
    """num_envs worlds on conf/env/<scene>.yaml, for gymnasium.make_vec; settings are keys of that file."""
    from curionav_cli.world.scene_file import plain

    raw, source = plain(scene, **settings)
    engine = raw.get("engine", "numpy")
    return NavigationVectorEnv(Scene.from_dict(raw, source), num_envs, render_mode, engine, max_episode_steps)
