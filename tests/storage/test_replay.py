"""Windows are whole, aligned, within one episode and uniform, wherever their frames are; pixels encode their place."""

import errno
import gc
import math

import numpy as np
import pytest
from scipy.stats import chisquare

from curionav_cli.decisions import Steps
from curionav_cli.errors import RunFolderError
from curionav_cli.storage.replay import NO_ACTION, Replay

FRAME = 64 * 64 * 3
# Bytes of frames in memory: nothing, one of the two episodes below, everything.
BOUNDS = pytest.mark.parametrize("memory", [0, 15 * FRAME, math.inf], ids=["disk", "both", "memory"])


def marked(an_episode, number, steps):
    """image[t] holds (episode, t); action[t] = 100 * episode + t led from t to t + 1."""
    episode = an_episode(steps=steps, seed=number)
    episode.image[:, 0, 0, 0] = number
    episode.image[:, 0, 0, 1] = np.arange(steps + 1)
    episode.action[:] = 100 * number + np.arange(steps)
    episode.pose[:] = np.column_stack([np.full(steps + 1, number), np.arange(steps + 1), np.zeros(steps + 1)])
    return episode


@pytest.fixture
def a_replay(tmp_path, an_episode):
    """a_replay(memory, 12, 20): episodes of 12 and 20 steps, frames beyond `memory` in tmp_path."""
    made = []

    def make(memory, *steps):
        episodes = (marked(an_episode, number, length) for number, length in enumerate(steps))
        made.append(Replay(episodes, memory=memory, folder=tmp_path))
        return made[-1]
    yield make
    for replay in made:
        replay.close()


def assert_windows(batch, images):
    """Every window is what the episode `images[e]` holds there, with the actions that led to it."""
    episode, t = batch["image"][..., 0, 0, 0].astype(int), batch["image"][..., 0, 0, 1].astype(int)
    assert (episode == episode[:, :1]).all()
    assert (t == t[:, :1] + np.arange(t.shape[1])).all()
    assert (batch["action"][:, 0] == NO_ACTION).all()
    assert (batch["action"][:, 1:] == 100 * episode[:, 1:] + t[:, 1:] - 1).all()
    np.testing.assert_array_equal(batch["is_start"], t[:, 0] == 0)
    np.testing.assert_array_equal(batch["pose"], np.stack([episode, t, 0 * t], -1))
    for e, first, window in zip(episode[:, 0], t[:, 0], batch["image"], strict=True):
        np.testing.assert_array_equal(window, images[e][first:first + len(window)])


@BOUNDS
def test_windows_are_contiguous_and_their_actions_lead_to_their_images(a_replay, an_episode, memory):
    images = [marked(an_episode, number, steps).image for number, steps in enumerate((12, 20))]
    batch = a_replay(memory, 12, 20).sample(64, 6, np.random.default_rng(0))
    assert batch["image"].shape == (64, 6, 64, 64, 3) and batch["image"].dtype == np.uint8
    assert batch["action"].shape == (64, 6)
    assert_windows(batch, images)


@BOUNDS
def test_every_window_is_as_likely_the_first_and_the_last_too(a_replay, memory):
    replay = a_replay(memory, 5, 2, 9)  # 3, 0 and 7 windows of 4 observations
    rng, windows = np.random.default_rng(1), []
    for _ in range(10):
        image = replay.sample(600, 4, rng)["image"]
        windows.append(10 * image[:, 0, 0, 0, 0].astype(int) + image[:, 0, 0, 0, 1])
    kinds, count = np.unique(np.concatenate(windows), return_counts=True)
    assert kinds.tolist() == [0, 1, 2, 20, 21, 22, 23, 24, 25, 26]
    assert chisquare(count).pvalue > 1e-3


def test_the_bound_changes_no_window(a_replay):
    lengths = np.random.default_rng(5).integers(3, 30, 12).tolist()
    batches = []
    for memory in (0, FRAME, 40 * FRAME, 100 * FRAME, math.inf):
        replay, rng = a_replay(memory, *lengths), np.random.default_rng(2)
        batches.append([replay.sample(7, 5, rng) for _ in range(6)])
        assert replay.in_memory <= memory
        assert replay.in_memory + replay.on_disk == sum(length + 1 for length in lengths) * FRAME
    for other in batches[1:]:
        for one, two in zip(batches[0], other, strict=True):
            assert all(one[key].tobytes() == two[key].tobytes() for key in ("image", "action", "pose", "is_start"))


def test_draws_are_those_of_the_first_replay(a_replay):
    """Old runs keep their bytes: one number a window, uniform over all windows in the order of the episodes."""
    which, start = a_replay(0, 5, 9, 7).draw(50, 4, np.random.default_rng(8))
    drawn = np.random.default_rng(8).integers(0, 3 + 7 + 5, 50)
    every = [(0, s) for s in range(3)] + [(1, s) for s in range(7)] + [(2, s) for s in range(5)]
    assert list(zip(which.tolist(), start.tolist(), strict=True)) == [every[d] for d in drawn]


@BOUNDS
def test_the_same_generator_gives_the_same_batch_and_the_store_is_not_shared(a_replay, memory):
    replay = a_replay(memory, 12, 14)
    one, two = (replay.sample(9, 5, np.random.default_rng(3)) for _ in range(2))
    np.testing.assert_array_equal(one["image"], two["image"])
    for array in one.values():
        array[:] = 0
    again = replay.sample(9, 5, np.random.default_rng(3))
    assert all((again[key] == two[key]).all() for key in two)


@BOUNDS
def test_episodes_come_while_others_are_drawn(a_replay, an_episode, memory):
    replay, rng = a_replay(memory, 12), np.random.default_rng(4)
    images = [marked(an_episode, number, 12).image for number in range(5)]
    for number in range(1, 5):
        assert_windows(replay.sample(20, 6, rng), images)
        replay.add(marked(an_episode, number, 12))
        assert len(replay) == number + 1 and replay.steps == 12 * (number + 1)
    seen = {batch["image"][0, 0, 0, 0, 0] for batch in (replay.sample(1, 6, rng) for _ in range(60))}
    assert seen == set(range(5))


@BOUNDS
def test_whole_episodes_come_back(a_replay, an_episode, memory):
    replay = a_replay(memory, 12, 20, 3)
    for index, number, steps in ((0, 0, 12), (1, 1, 20), (2, 2, 3), (-1, 2, 3)):
        ours, theirs = replay.episode(index), marked(an_episode, number, steps)
        for name in ("image", "action", "pose", "collided", "events"):
            np.testing.assert_array_equal(getattr(ours, name), getattr(theirs, name))
    with pytest.raises(IndexError):
        replay.episode(3)


def test_too_short_episodes_are_refused(a_replay):
    for replay in (a_replay(0, 7), a_replay(0), a_replay(math.inf)):
        with pytest.raises(ValueError, match=r"no episode holds a sequence of 9 observations; raise loop\.steps"):
            replay.sample(2, 9, np.random.default_rng(0))


def test_a_reopened_folder_gives_the_same_batches(tmp_path, an_episode):
    episodes = [marked(an_episode, n, 8) for n in range(3)]
    for n, episode in enumerate(episodes):
        episode.action[:] %= 3
        episode.save(tmp_path / f"{n:06d}.npz")
    for memory in (0, 10 * FRAME, math.inf):
        back = Replay.open(sorted(tmp_path.iterdir()), memory=memory, folder=tmp_path)
        assert back.steps == 24 and len(back) == 3
        np.testing.assert_array_equal(back.sample(5, 4, np.random.default_rng(0))["image"],
                                      Replay(episodes).sample(5, 4, np.random.default_rng(0))["image"])
        back.close()


def test_nothing_is_left_in_the_folder_and_the_disk_is_given_back(tmp_path, a_replay):
    replay = a_replay(0, 12, 20)
    assert replay.on_disk == 34 * FRAME and replay.in_memory == 0
    assert list(tmp_path.iterdir()) == []  # whatever ends the process, there is nothing to remove
    replay.close()
    gc.collect()  # an unclosed file would warn, and warnings are errors


def test_a_full_disk_is_reported_as_such(tmp_path, an_episode, monkeypatch):
    replay = Replay([marked(an_episode, 0, 5)], memory=6 * FRAME, folder=tmp_path)

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")
    with monkeypatch.context() as patched:
        patched.setattr("curionav_cli.storage.scratch.os.pwrite", full)
        with pytest.raises(OSError, match="No space left"):
            replay.add(marked(an_episode, 1, 5))
    assert len(replay) == 1 and replay.steps == 5
    replay.add(marked(an_episode, 1, 5))
    np.testing.assert_array_equal(replay.episode(1).image, marked(an_episode, 1, 5).image)
    replay.close()


def test_a_disk_that_takes_and_gives_little_at_a_time(a_replay, an_episode, monkeypatch):
    from curionav_cli.storage import scratch

    write, read = scratch.os.pwrite, scratch.os.preadv
    monkeypatch.setattr(scratch.os, "pwrite", lambda file, data, place: write(file, data[:5000], place))
    monkeypatch.setattr(scratch.os, "preadv", lambda file, views, place: read(file, [views[0][:7000]], place))
    images = [marked(an_episode, number, 12).image for number in range(2)]
    assert_windows(a_replay(0, 12, 12).sample(8, 6, np.random.default_rng(0)), images)


def test_a_broken_episode_is_named(tmp_path):
    (tmp_path / "000000.npz").write_bytes(b"PK")
    with pytest.raises(RunFolderError, match=r"000000\.npz is not whole"):
        Replay.open([tmp_path / "000000.npz"])


@BOUNDS
def test_of_held_actions_only_the_frames_that_were_acted_on_are_kept(tmp_path, an_episode, memory):
    episode = marked(an_episode, 0, 21)
    episode.action[:] = np.arange(21) // 4
    replay = Replay([episode], memory=memory, folder=tmp_path, every=Steps(4))
    batch = replay.sample(32, 3, np.random.default_rng(0))
    shown = batch["image"][..., 0, 0, 1].astype(int)
    assert set(shown[:, 0]) == {0, 4, 8, 12} and (np.diff(shown, axis=1) == 4).all()
    assert (batch["action"][:, 1:] == shown[:, :-1] // 4).all()
    assert replay.steps == 20 and replay.in_memory + replay.on_disk == 6 * FRAME
    replay.close()


@BOUNDS
def test_a_bounded_replay_is_that_of_its_newest_episodes(an_episode, tmp_path, memory):
    steps = (12, 20, 9, 20, 15)
    episodes = [marked(an_episode, number, length) for number, length in enumerate(steps)]
    replay = Replay(episodes, memory=memory, folder=tmp_path, newest=2)
    assert (len(replay), replay.dropped, replay.steps) == (5, 3, 35)
    assert replay.in_memory + replay.on_disk <= (21 + 21 + 16) * FRAME  # room of what is gone is used again
    batch = replay.sample(64, 6, np.random.default_rng(0))
    assert_windows(batch, [episode.image for episode in episodes])
    assert set(batch["pose"][:, 0, 0]) == {3, 4}
    paths = [tmp_path / f"{number}.npz" for number in range(5)]
    for episode, path in list(zip(episodes, paths, strict=True))[3:]:
        episode.action[:] %= 3
        episode.save(path)
    opened = Replay.open(paths, memory=memory, folder=tmp_path, newest=2)  # the others are not even looked for
    again = opened.sample(64, 6, np.random.default_rng(0))
    np.testing.assert_array_equal(again["image"], batch["image"])
    with pytest.raises(LookupError, match="episode 2 is older than the newest 2"):
        opened.episode(2)
    for one in (replay, opened):
        one.close()
