"""Gymnasium's own wrappers and vectors around our worlds."""

from __future__ import annotations

import gymnasium
import numpy as np
import pytest
from gymnasium import wrappers
from gymnasium.vector import AutoresetMode

from curionav_cli.world.registration import register


def room(**settings) -> gymnasium.Env:
    register()
    return gymnasium.make("curionav/SmallRoom-v0", reward="coverage", **settings)


@pytest.mark.parametrize("steps", [2, 3])
def test_episodes_are_counted(steps: int) -> None:
    """info["episode"] is the key of gymnasium's statistics."""
    env = wrappers.RecordEpisodeStatistics(room(max_episode_steps=steps))
    for _ in range(2):
        env.reset(seed=0)
        infos = [env.step(0)[4] for _ in range(steps)]
        assert infos[-1]["episode"]["l"] == steps and infos[-1]["episode"]["r"] > 0


def test_frames_are_stacked_and_flattened() -> None:
    stacked, flat = wrappers.FrameStackObservation(room(), 4), wrappers.FlattenObservation(room())
    seen, _ = stacked.reset(seed=0)
    assert stacked.observation_space.contains(seen) and seen["image"].shape == (4, 64, 64, 3)
    seen, _ = flat.reset(seed=0)
    assert flat.observation_space.contains(seen) and seen.shape == (4 * 64 * 64,)


@pytest.mark.filterwarnings("ignore:This process .* is multi-threaded:DeprecationWarning")
@pytest.mark.parametrize("context", ["spawn", "forkserver"])
def test_workers_see_the_same(context: str) -> None:
    """The id names our package, which a new process has not imported."""
    register()
    apart = gymnasium.make_vec("curionav_cli:curionav/SmallRoom-v0", num_envs=2, vectorization_mode="async",
                               vector_kwargs={"context": context}, max_episode_steps=2)
    ours = gymnasium.make_vec("curionav/SmallRoom-v0", num_envs=2, autoreset_mode=AutoresetMode.NEXT_STEP,
                              max_episode_steps=2)
    for one, other in [(apart.reset(seed=3), ours.reset(seed=3)),
                       *((apart.step(turn), ours.step(turn)) for turn in np.array([[0, 1], [2, 0], [0, 0]]))]:
        assert all(np.array_equal(one[0][key], other[0][key]) for key in ("image", "depth"))
        assert set(one[-1]) == set(other[-1])
        assert all(np.array_equal(one[-1][key], other[-1][key]) for key in one[-1])
    apart.close()
