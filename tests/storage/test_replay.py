"""Windows are whole, aligned, within one episode and uniform; every pixel here tells where it is from."""

import numpy as np
import pytest
from scipy.stats import chisquare

from curionav_cli.storage.replay import NO_ACTION, Replay


def marked(an_episode, number, steps):
    """image[t] holds (episode, t); action[t] = 100 * episode + t led from t to t + 1."""
    episode = an_episode(steps=steps)
    episode.image[:, 0, 0, 0] = number
    episode.image[:, 0, 0, 1] = np.arange(steps + 1)
    episode.action[:] = 100 * number + np.arange(steps)
    return episode


def test_windows_are_contiguous_and_their_actions_lead_to_their_images(an_episode):
    replay = Replay([marked(an_episode, 0, 12), marked(an_episode, 1, 20)])
    batch = replay.sample(64, 6, np.random.default_rng(0))
    assert batch["image"].shape == (64, 6, 64, 64, 3) and batch["action"].shape == (64, 6)
    episode, t = batch["image"][..., 0, 0, 0].astype(int), batch["image"][..., 0, 0, 1].astype(int)
    assert (episode == episode[:, :1]).all()
    assert (t == t[:, :1] + np.arange(6)).all()
    assert (batch["action"][:, 0] == NO_ACTION).all()
    assert (batch["action"][:, 1:] == 100 * episode[:, 1:] + t[:, 1:] - 1).all()
    np.testing.assert_array_equal(batch["is_start"], t[:, 0] == 0)


def test_every_window_is_as_likely_the_first_and_the_last_too(an_episode):
    replay = Replay([marked(an_episode, 0, 5), marked(an_episode, 1, 9)])  # 3 and 7 windows of 4 observations
    batch = replay.sample(6000, 4, np.random.default_rng(1))
    window = 10 * batch["image"][:, 0, 0, 0, 0].astype(int) + batch["image"][:, 0, 0, 0, 1]
    kinds, count = np.unique(window, return_counts=True)
    assert kinds.tolist() == [0, 1, 2, 10, 11, 12, 13, 14, 15, 16]
    assert chisquare(count).pvalue > 1e-3


def test_the_same_generator_gives_the_same_batch_and_the_store_is_not_shared(an_episode):
    replay = Replay([marked(an_episode, 0, 12)])
    one, two = (replay.sample(4, 5, np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(one["image"], two["image"])
    one["image"][:] = 0
    np.testing.assert_array_equal(replay.sample(4, 5, np.random.default_rng(3))["image"], two["image"])


def test_too_short_episodes_are_refused(an_episode):
    with pytest.raises(ValueError, match=r"no episode holds a sequence of 9 observations; raise loop\.steps"):
        Replay([marked(an_episode, 0, 7)]).sample(2, 9, np.random.default_rng(0))


def test_a_reopened_folder_gives_the_same_batches(tmp_path, an_episode):
    episodes = [marked(an_episode, n, 8) for n in range(3)]
    for n, episode in enumerate(episodes):
        episode.save(tmp_path / f"{n:06d}.npz")
    back = Replay.open(sorted(tmp_path.iterdir()))
    assert back.steps == 24
    np.testing.assert_array_equal(back.sample(5, 4, np.random.default_rng(0))["image"],
                                  Replay(episodes).sample(5, 4, np.random.default_rng(0))["image"])
