"""A vector environment: many worlds step in one call, and the images that changed are rendered in one batch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from curionav_cli.constants import FORWARD, HEADINGS, IMAGE_SIDE, LEFT, RIGHT
from curionav_cli.world import motion
from curionav_cli.world.env import METADATA, Observation, actions, observations, seen
from curionav_cli.world.keywords import build_scene, check_size
from curionav_cli.world.pictures import Pictures
from curionav_cli.world.registration import STEPS
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.resets import EpisodeCounter, check_render_mode, episode_of, mask_of, seeds_of
from curionav_cli.world.reward import Reward
from curionav_cli.world.scene.scene import Scene

Info = dict[str, Any]
ALLOWED = frozenset((FORWARD, LEFT, RIGHT))


class NavigationVectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """A Gymnasium vector environment of E worlds: world i equals a NavigationEnv with the same seed, to the byte.

    Actions (E,); observation: image (E, S, S, 3) uint8 RGB, depth (E, S, S) float32 metres, S = side. A step raises
    ValueError for other actions, ResetNeeded where a world was never reset, or has ended in mode DISABLED.
    Info holds arrays: pose (E, 3), collided (E,), episode_index (E,), and their masks `_pose`, `_collided` and so on.
    A world ends only if max_episode_steps says so. Then autoreset_mode counts: SAME_STEP puts it back to the start in
    the same step, so that every action is carried out (final_obs and final_info hold the last observation); NEXT_STEP
    in the next one, whose action is ignored; DISABLED leaves it to `reset(options={"reset_mask": mask})`, which resets
    some worlds in every mode. reward and reset_mode: as of NavigationEnv.
    """

    metadata: dict[str, Any] = METADATA | {"autoreset_mode": AutoresetMode.SAME_STEP}

    def __init__(self, scene: Scene, num_envs: int = 1, render_mode: str | None = None, engine: str = "numpy",
                 max_episode_steps: int | None = None, autoreset_mode: AutoresetMode | str = AutoresetMode.SAME_STEP,
                 reward: str = "none", reset_mode: str = "restart", observation: str = "dict",
                 side: int = IMAGE_SIDE):
        check_render_mode(render_mode, METADATA["render_modes"])
        check_end(max_episode_steps)
        self.scene, self.num_envs, self.render_mode = scene, num_envs, render_mode
        self.max_episode_steps = max_episode_steps
        self.autoreset_mode = mode_of(autoreset_mode)
        self.metadata = {**METADATA, "autoreset_mode": self.autoreset_mode}
        self.observation = observation
        self.single_action_space, self.single_observation_space = actions(), observations(observation, side)
        self.action_space = batch_space(actions(), num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._counters = [EpisodeCounter(reset_mode) for _ in range(num_envs)]
        self._rewards = [Reward(reward) for _ in range(num_envs)]
        self._events: list[tuple[dict[str, Any], ...]] = [()] * num_envs
        self._now = [scene] * num_envs
        self._renderers = [Renderer(scene, engine, side=side)] * num_envs
        self._brightness = np.ones(num_envs)
        self._x, self._y = np.zeros(num_envs), np.zeros(num_envs)
        self._heading, self._episode, self._steps = np.zeros((3, num_envs), np.int64)
        self._over = np.zeros(num_envs, bool)
        self._pictures = Pictures(num_envs, side)

    @property
    def engine(self) -> str:
        """The rendering engine: numpy or numba."""
        return self._renderers[0].engine

    @property
    def now(self) -> list[Scene]:
        """The scene of each world's episode."""
        return list(self._now)

    @property
    def events(self) -> list[tuple[dict[str, Any], ...]]:
        """The changes in each world before its episode: moved objects, light."""
        return list(self._events)

    def reset(self, *, seed: int | list[int | None] | None = None,
              options: dict[str, Any] | None = None) -> tuple[Any, Info]:
        """Reset the worlds. seed s: runs s, s + 1, ...; a list: one run for each; None: the next episode of each."""
        seeds, episode = seeds_of(seed, self.num_envs), episode_of(options)
        mask = mask_of(options, self.num_envs)
        named = [one for one in seeds if one is not None]
        super().reset(seed=named[0] if named else None)
        self._begin(mask, seeds, episode)
        self._started()
        self._render(mask)
        return self._seen(), self._info(np.zeros(self.num_envs, bool), mask)

    def step(self, actions: np.ndarray) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, Info]:
        self._started()
        actions = np.asarray(actions)
        if actions.shape != (self.num_envs,) or not ALLOWED.issuperset(actions.tolist()):
            raise ValueError(f"actions {actions!r} are not {self.num_envs} of 0 forward, 1 left, 2 right")
        again, over = self._over.copy(), np.zeros(self.num_envs, bool)  # again: only in NEXT_STEP
        changed, collided = self._act(actions, ~again)
        self._begin(again)
        self._render(changed | again)
        earned = self._reward(~again)
        self._steps += ~again
        if self.max_episode_steps is not None:
            over = self._steps >= self.max_episode_steps
        info = self._info(collided)
        if self.autoreset_mode is not AutoresetMode.SAME_STEP:
            self._over = over
        elif over.any():
            info = self._reset_ended(over, info)
        return self._seen(), earned, np.zeros(self.num_envs, bool), over.copy(), info

    def render(self) -> tuple[np.ndarray, ...]:
        """The camera image of each world, (S, S, 3) uint8."""
        self._started()
        return tuple(self._observation()["image"])

    def look(self, x, y, yaw) -> Observation:
        """Render one other pose in each world, (E,) each, yaw in radians. Nothing moves."""
        return self._drawn(np.arange(self.num_envs), Renderer.look, *map(np.asarray, (x, y, yaw)))

    def panorama(self, views: int = 4) -> Observation:
        """Render `views` directions around each pose, the first ahead: image (E, views, S, S, 3), depth alike."""
        self._started()
        return self._drawn(np.arange(self.num_envs), Renderer.panorama, self._x, self._y, self._heading, views=views)

    def _started(self) -> None:
        """Raise ResetNeeded where a world was never reset, or has ended and is not reset automatically."""
        for counter in self._counters:
            counter.require()
        if self.autoreset_mode is AutoresetMode.DISABLED and self._over.any():
            raise ResetNeeded(f"The episodes of worlds {np.flatnonzero(self._over).tolist()} have ended: call "
                              'reset(options={"reset_mask": mask}) first, or choose another autoreset_mode.')

    def _act(self, actions: np.ndarray, acting: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The worlds of this mask move: (E,) did its pose change, (E,) did it collide?"""
        turn = ((actions == LEFT).astype(np.int64) - (actions == RIGHT)) * acting
        self._heading = (self._heading + turn) % HEADINGS
        changed, collided = turn != 0, np.zeros(self.num_envs, bool)
        for world in np.flatnonzero((actions == FORWARD) & acting).tolist():
            changed[world], collided[world] = self._forward(world)
        return changed, collided

    def _forward(self, world: int) -> tuple[bool, bool]:
        """Did the pose change, did it collide?"""
        plan, before = self._now[world].plan, (float(self._x[world]), float(self._y[world]))
        x, y, collided = motion.forward(plan.visitable, plan.cell, *before, int(self._heading[world]),
                                        self.scene.collision)
        self._x[world], self._y[world] = x, y
        if (x, y) != before:
            self._pictures.forget(world)
        return (x, y) != before, collided

    def _reward(self, acting: np.ndarray) -> np.ndarray:
        """The reward of this step, (E,); 0.0 of a world that was only reset."""
        where = zip(self._rewards, self._x.tolist(), self._y.tolist(), acting.tolist(), strict=True)
        return np.array([reward.step(x, y) if acts else 0.0 for reward, x, y, acts in where])

    def _begin(self, which: np.ndarray, seeds: list[int | None] | None = None, episode: int | None = None) -> None:
        """Begin the next episode in the worlds of this mask, or the one given."""
        start = self.scene.plan.start
        for world in np.flatnonzero(which).tolist():
            counter = self._counters[world]
            counter.reset(seeds[world] if seeds else None, episode)
            now, self._events[world] = self.scene.at(counter.episode, counter.seed)
            self._now[world], self._brightness[world], self._episode[world] = now, now.brightness, counter.episode
            self._renderers[world] = self._renderers[world].showing(now)
            self._pictures.forget(world)
            self._rewards[world].reset(now.plan, start.x, start.y)
        self._x[which], self._y[which] = start[:2]
        self._heading[which], self._steps[which], self._over[which] = self.scene.start_heading, 0, False

    def _reset_ended(self, ended: np.ndarray, last: Info) -> Info:
        """Reset the worlds of this mask; the info of the step, with their last observations and infos."""
        final = np.full(self.num_envs, None, object)
        for world in np.flatnonzero(ended).tolist():
            final[world] = seen(self._pictures.one(world, int(self._heading[world])), self.observation)
        masks = {key: ended for key in last if key.startswith("_")}
        self._begin(ended)
        self._render(ended)
        return {**self._info(last["collided"] & ~ended), "final_obs": final, "_final_obs": ended,
                "final_info": {**last, **masks}, "_final_info": ended}

    def _render(self, mask: np.ndarray) -> None:
        heading = self._heading.tolist()
        new = self._pictures.missing(np.flatnonzero(mask).tolist(), heading)
        if new:
            which = np.array(new)
            images = self._drawn(which, Renderer.render, self._x[which], self._y[which], self._heading[which])
            for world, image, depth in zip(new, images["image"], images["depth"], strict=True):
                self._pictures.keep(world, heading[world], image, depth)

    def _drawn(self, which: np.ndarray, draw: Callable[..., tuple[np.ndarray, np.ndarray]], *poses: np.ndarray,
               **how: Any) -> Observation:
        """Images of worlds `which`, in one call for all worlds whose objects stand alike."""
        groups: dict[int, list[int]] = {}
        for place, world in enumerate(which.tolist()):
            groups.setdefault(id(self._renderers[world].camera), []).append(place)
        pieces = [draw(self._renderers[which[group[0]]], *(part[group] for part in poses),
                       brightness=self._brightness[which[group]], **how) for group in groups.values()]
        if len(pieces) == 1:
            return {"image": pieces[0][0], "depth": pieces[0][1]}
        back = np.argsort(np.concatenate([np.array(group) for group in groups.values()]))
        image, depth = (np.concatenate(part)[back] for part in zip(*pieces, strict=True))
        return {"image": image, "depth": depth}

    def _seen(self) -> Any:
        return seen(self._observation(), self.observation)

    def _observation(self) -> Observation:
        return self._pictures.all(self._heading.tolist())

    def _info(self, collided: np.ndarray, mask: np.ndarray | None = None) -> Info:
        """The info of the worlds of this mask, or of all."""
        mask = np.ones(self.num_envs, bool) if mask is None else mask
        pose = np.stack([self._x, self._y, motion.YAW[self._heading]], axis=1)
        info = {"pose": pose, "collided": collided, "episode_index": self._episode.copy()}
        return info | {f"_{key}": mask.copy() for key in info}


def check_end(max_episode_steps: int | None) -> None:
    """Raise ValueError unless max_episode_steps is a positive integer or None."""
    if max_episode_steps is not None and not (isinstance(max_episode_steps, int) and max_episode_steps >= 1):
        raise ValueError(f"max_episode_steps must be 1 or more, or None, not {max_episode_steps!r}.")


def mode_of(name: AutoresetMode | str) -> AutoresetMode:
    """An AutoresetMode from itself or its value. Raises ValueError for another one."""
    try:
        return AutoresetMode(name)
    except ValueError:
        names = ", ".join(mode.value for mode in AutoresetMode)
        raise ValueError(f"autoreset_mode must be one of {names}, not {name!r}.") from None


def make(scene: str, num_envs: int = 1, render_mode: str | None = None, max_episode_steps: int | None = None,
         autoreset_mode: AutoresetMode | str = AutoresetMode.SAME_STEP, reward: str = "none",
         reset_mode: str = "restart", observation: str = "dict", action: str = "discrete",
         size: int = IMAGE_SIDE, **settings: Any) -> NavigationVectorEnv:
    """Make a NavigationVectorEnv of conf/env/<scene>.yaml, for gymnasium.make_vec; settings are keys of that file.

    max_episode_steps: as of gymnasium.make, None for the 500 of the registration, -1 for no end. size: of the square
    images, pixels a side. Raises ValueError for continuous actions.
    """
    if action != "discrete":
        raise ValueError(f"action={action!r}: worlds in one batch have discrete actions. Add vectorization_mode='sync' "
                         "or 'async'.")
    world, engine = build_scene(make, scene, settings)
    limit = STEPS if max_episode_steps is None else max_episode_steps
    return NavigationVectorEnv(world, num_envs, render_mode, engine, None if limit == -1 else limit, autoreset_mode,
                               reward, reset_mode, observation, check_size(size, engine))
