"""Arguments of reset and of an environment, checked alike for a single environment and a vector of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium.error import Error, ResetNeeded

SEEDS = 2**64  # a seed is below this, as numpy's SeedSequence and a C++ trainer take it
EPISODES = 2**63  # the number of an episode is below this: info holds it as int64
RESET_MODES = ("restart", "continue")


class EpisodeCounter:
    """The current run and episode: a seed names a run, and its episodes count from 0.

    reset_mode restart: a reset with a seed begins that run, one without begins the next episode. continue: only the
    first reset begins a run, later ones begin the next episode, for trainers that seed every reset. options["episode"]
    selects an episode in both modes, of the run named by the seed beside it. Raises ValueError for another mode.
    """

    def __init__(self, reset_mode: str = "restart"):
        if reset_mode not in RESET_MODES:
            raise ValueError(f"reset_mode must be one of {', '.join(RESET_MODES)}, not {reset_mode!r}.")
        self.continues = reset_mode == "continue"
        self.seed, self.episode = 0, -1

    def reset(self, seed: int | None, episode: int | None) -> None:
        """Set seed and episode for a reset with this seed and this episode of the options."""
        first = self.episode < 0
        if seed is not None and (first or episode is not None or not self.continues):
            self.seed, self.episode = seed, -1
        self.episode = self.episode + 1 if episode is None else episode

    def require(self) -> None:
        """Raise ResetNeeded before the first reset."""
        if self.episode < 0:
            raise ResetNeeded("No episode has begun: call reset() first.")


def seed_of(seed: Any) -> int | None:
    """A seed as an int, or None. Raises gymnasium's Error for anything but an integer from 0 to 2**64 - 1."""
    if seed is None:
        return None
    if not isinstance(seed, int | np.integer):
        raise Error(f"A seed must be an integer, not {seed!r}.")
    if not 0 <= seed < SEEDS:
        raise Error(f"A seed must be from 0 to 2**64 - 1, not {seed}.")
    return int(seed)


def seeds_of(seed: Any, worlds: int) -> list[int | None]:
    """A seed for each world: s, s + 1, ... of one integer s, or those of a list. Raises Error or ValueError."""
    if seed is None or isinstance(seed, int | np.integer):
        return [seed_of(None if seed is None else int(seed) + world) for world in range(worlds)]
    if not isinstance(seed, list | tuple | np.ndarray):
        raise Error(f"seed must be an integer or a list of {worlds}, not {seed!r}.")
    if len(seed) != worlds:
        raise ValueError(f"{len(seed)} seeds for {worlds} worlds: name one for each, None for the next episode.")
    return [seed_of(one) for one in seed]


def episode_of(options: Mapping[str, Any] | None) -> int | None:
    """The episode in the options, or None. Raises ValueError for anything but an integer from 0 to 2**63 - 1."""
    episode = (options or {}).get("episode")
    if episode is None:
        return None
    if not isinstance(episode, int | np.integer) or not 0 <= episode < EPISODES:
        raise ValueError(f'options["episode"] must be an integer from 0 to 2**63 - 1, not {episode!r}.')
    return int(episode)


def mask_of(options: Mapping[str, Any] | None, worlds: int) -> np.ndarray:
    """The worlds to reset, (worlds,) bool: options["reset_mask"], or all. Raises ValueError for another shape."""
    mask = np.asarray((options or {}).get("reset_mask", np.ones(worlds, bool)))
    if mask.dtype != bool or mask.shape != (worlds,) or not mask.any():
        raise ValueError(f'options["reset_mask"] must be {worlds} booleans, one of them true at least, not {mask!r}.')
    return mask


def check_render_mode(render_mode: Any, modes: list[str]) -> None:
    """Raise ValueError for a mode that is none of these."""
    if render_mode is not None and render_mode not in modes:
        raise ValueError(
            f"render_mode must be {' or '.join(map(repr, modes))} or None, not {render_mode!r}. For a film wrap the "
            'environment in gymnasium.wrappers.RecordVideo, for a window in gymnasium.wrappers.HumanRendering.')
