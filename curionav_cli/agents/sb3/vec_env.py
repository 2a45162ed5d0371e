"""Worlds of gymnasium.make_vec, which are drawn in one batch, as a vector environment of Stable-Baselines3."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from stable_baselines3.common.vec_env import VecEnv


class SB3VecEnv(VecEnv):
    """Steps `worlds`, which reset themselves in the same step; world i equals one in a DummyVecEnv, to the byte.

    After reset and step `reset_infos` hold the infos of the last resets. The info of a step that ends an episode is the
    episode's last, with terminal_observation. VecMonitor, or Gymnasium's RecordEpisodeStatistics for vectors inside,
    counts returns and lengths. Raises ValueError for worlds of another autoreset mode.
    """

    def __init__(self, worlds: VectorEnv[Any, Any, Any]):
        mode = worlds.metadata.get("autoreset_mode")
        if mode is not AutoresetMode.SAME_STEP:
            raise ValueError(f"Stable-Baselines3 resets a world in the step that ends its episode, and these have "
                             f"autoreset_mode={mode}. Make them with autoreset_mode=AutoresetMode.SAME_STEP.")
        self.worlds: Any = worlds
        super().__init__(worlds.num_envs, worlds.single_observation_space, worlds.single_action_space)

    def reset(self) -> Any:
        """The first observations. Seeds and options that were set are used once; all worlds have the same options."""
        first, *others = self._options
        if any(other != first for other in others):
            raise ValueError("worlds in one batch are reset with the same options; set_options was given several.")
        seen, info = self.worlds.reset(seed=self._seeds, options=first or None)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [of_world(info, world) for world in range(self.num_envs)]
        return seen

    def step_async(self, actions: np.ndarray) -> None:
        """Keep the actions (E,) for step_wait."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Observations, rewards (E,) float32, whether an episode ended (E,), an info of each world."""
        seen, earned, over, cut, info = self.worlds.step(self._actions)
        ended, last, final = over | cut, info.pop("final_info", {}), info.pop("final_obs", None)
        infos = [of_world(info, world) for world in range(self.num_envs)]
        for world in np.flatnonzero(ended).tolist():
            self.reset_infos[world] = infos[world]
            infos[world] = {**infos[world], **of_world(last, world), "terminal_observation": final[world]}
        for one, late, early in zip(infos, cut.tolist(), over.tolist(), strict=True):
            one["TimeLimit.truncated"] = late and not early
        return seen, earned.astype(np.float32), ended, infos

    def close(self) -> None:
        self.worlds.close()

    def get_images(self) -> list[np.ndarray | None]:
        """What each world's camera sees, (S, S, 3) uint8; None where render_mode is."""
        return [None] * self.num_envs if self.render_mode is None else list(self.worlds.render())

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the worlds: that of each, where it is a list as `events`; else the same for all."""
        value = getattr(self.worlds.unwrapped, attr_name)
        return [value[world] if isinstance(value, list) else value for world in self._which(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of all worlds. Raises ValueError for some of them."""
        if len(set(self._which(indices))) != self.num_envs:
            raise ValueError(f"{attr_name} is one for all worlds in a batch; leave indices out.")
        setattr(self.worlds.unwrapped, attr_name, value)

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Raises AttributeError: worlds in a batch have no methods of their own."""
        raise AttributeError(f"worlds in a batch have no {method_name} of their own; .worlds are all of them.")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """None is wrapped: wrappers are around all of them."""
        return [False for _ in self._which(indices)]

    def _which(self, indices: Any) -> list[int]:
        return list(self._get_indices(indices))


def of_world(info: dict[str, Any], world: int) -> dict[str, Any]:
    """The info of one world from arrays over worlds and their masks `_key`."""
    return {key: of_world(value, world) if isinstance(value, dict) else value[world] for key, value in info.items()
            if not key.startswith("_") and (f"_{key}" not in info or info[f"_{key}"][world])}
