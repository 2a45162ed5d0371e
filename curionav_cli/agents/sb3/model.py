"""An algorithm of Stable-Baselines3 without its loop: built on spaces alone, its methods called by ours."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from typing import Any

import gymnasium
import numpy as np
import torch
from stable_baselines3.common.logger import Logger

from curionav_cli.agents.sb3 import CONTRIB
from curionav_cli.agents.sb3.settings import SB3, Algorithm
from curionav_cli.constants import ACTIONS, IMAGE_SHAPE
from curionav_cli.errors import ConfigError

OURS = {"policy", "env", "seed", "device", "verbose", "tensorboard_log", "stats_window_size", "n_steps", "use_sde",
        "sde_sample_freq", "buffer_size", "train_freq", "gradient_steps", "optimize_memory_usage",
        "rollout_buffer_class", "rollout_buffer_kwargs", "replay_buffer_class", "replay_buffer_kwargs"}


class Spaces(gymnasium.Env[Any, Any]):
    """The spaces of an episode: images with the channels first. Nothing is ever stepped."""

    observation_space = gymnasium.spaces.Box(0, 255, (IMAGE_SHAPE[2], *IMAGE_SHAPE[:2]), np.uint8)
    action_space = gymnasium.spaces.Discrete(len(ACTIONS))


@contextmanager
def seeded(rng: np.random.Generator) -> Iterator[None]:
    """Seed the global generators of numpy and torch, which SB3 draws from, by a number of `rng`; then restore them."""
    before, torchs, seed = np.random.get_state(), torch.get_rng_state(), int(rng.integers(2**32))  # noqa: NPY002
    np.random.seed(seed)  # noqa: NPY002
    torch.manual_seed(seed)
    try:
        yield
    finally:
        np.random.set_state(before)  # noqa: NPY002
        torch.set_rng_state(torchs)


def build(own: SB3, device: torch.device, **fixed: Any) -> Any:
    """Make the algorithm that the settings name. fixed: arguments that are not the user's.

    Raises ConfigError for a parameter that it does not have, or a value that it refuses.
    """
    import sb3_contrib
    import stable_baselines3

    maker = getattr(sb3_contrib if own.algorithm in CONTRIB else stable_baselines3, own.algorithm.value)
    refuse_unknown(own, maker)
    policy = "CnnLstmPolicy" if own.algorithm is Algorithm.RecurrentPPO else "CnnPolicy"
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # that the last minibatch of a rollout is smaller
            # A2C and QRDQN write their optimiser into the caller's policy_kwargs, hence the copy
            model = maker(policy, Spaces(), device=device, **fixed, **deepcopy(own.parameters))
    except (AssertionError, TypeError, ValueError) as error:
        line = next(iter(str(error).splitlines()), type(error).__name__)
        raise ConfigError(f"agent.parameters: {own.algorithm.value} refuses {own.parameters}: {line}") from error
    model.set_logger(Logger(None, []))
    return model


def refuse_unknown(own: SB3, maker: type) -> None:
    """Raises ConfigError for a parameter that the algorithm does not have, or that our loop sets."""
    has = [name for name in inspect.signature(maker).parameters if name not in OURS and not name.startswith("_")]
    for name in own.parameters:
        if name not in has:
            raise ConfigError(f"agent.parameters.{name} is no setting of {own.algorithm.value} here. It has: "
                              f"{', '.join(has)}.")


def metrics(model: Any) -> dict[str, float]:
    """Read what the algorithm has logged since the last call, under the names that it gives."""
    logged = {name.removeprefix("train/"): float(value) for name, value in model.logger.name_to_value.items()
              if name.startswith("train/") and isinstance(value, int | float | np.number)}
    model.logger.name_to_value.clear()
    return {name: value for name, value in logged.items() if name != "n_updates"}
