"""A thinned episode is the same but for images that are gone; who needs one of those is told so."""

import numpy as np
import pytest

from curionav_cli.decisions import Steps
from curionav_cli.errors import RunFolderError
from curionav_cli.records import Episode, Prediction, Surprise
from curionav_cli.storage import pictures
from curionav_cli.storage.episodes import longest
from curionav_cli.storage.replay import Replay

HELD = Steps(4)


@pytest.fixture
def stored(tmp_path, an_episode):
    """(file, episode) of 21 steps, whose actions are held for 4."""
    episode = an_episode(steps=21)
    episode.action[:] = np.repeat([0, 1, 2, 0, 1, 2], 4)[:21]
    path = tmp_path / "000000.npz"
    episode.save(path)
    return path, episode


def test_only_images_go_and_thinning_again_adds_none(stored):
    path, whole = stored
    before = path.stat().st_size
    pictures.thin(path, np.array([0, 4, 8]))
    thinned = Episode.load(path, thinned=True)
    np.testing.assert_array_equal(thinned.image, whole.image[[0, 4, 8]])
    for name in ("action", "pose", "collided"):
        np.testing.assert_array_equal(getattr(thinned, name), getattr(whole, name))
    assert path.stat().st_size < before / 5
    assert not pictures.gone(path)
    after = path.read_bytes()
    pictures.thin(path, np.arange(22))
    assert path.read_bytes() == after
    with pytest.raises(RunFolderError, match=r"000000.npz holds 3 of its 22 images: .*loop.keep=all"):
        Episode.load(path)
    np.testing.assert_array_equal(pictures.images(path, [4, 8]), whole.image[[4, 8]])
    with pytest.raises(RunFolderError, match=r"000000.npz holds 3 of its 22 images"):
        pictures.images(path, [-1])
    pictures.thin(path, np.zeros(0, np.int64))
    assert pictures.gone(path)
    assert not len(Episode.load(path, thinned=True).image)


def test_a_replay_draws_the_same_from_thinned_episodes(stored):
    path, whole = stored
    pictures.thin(path, HELD.decisions(whole.action, whole.collided).frame)
    rng = np.random.default_rng
    ours, theirs = (one.sample(9, 3, rng(0)) for one in (Replay.open([path], every=HELD), Replay([whole], every=HELD)))
    assert all(np.array_equal(ours[key], theirs[key]) for key in theirs)
    assert longest(path.parent, [path.name], HELD) == 5
    with pytest.raises(RunFolderError, match="holds 6 of its 22 images"):
        Replay.open([path])
    with pytest.raises(RunFolderError, match=r"For an agent with actions they are too few. .* set agent.action_r"):
        longest(path.parent, [path.name], Steps())


@pytest.mark.parametrize("kept", [[3, 3], [-1, 2], [2, 22], [5, 1]], ids=str)
def test_frames_that_cannot_be_are_refused(stored, kept):
    path, whole = stored
    Episode(**{**vars(whole), "image": whole.image[:2], "kept": np.array(kept)}).save(path)
    with pytest.raises(RunFolderError, match="`kept` does not rise from 0 to 21"):
        Episode.load(path, thinned=True)


def test_a_prediction_without_images_has_its_errors_and_its_surprise(tmp_path):
    numbers = np.arange(6.0, dtype=np.float32).reshape(2, 3)
    surprise = Surprise(np.arange(6).reshape(2, 3), numbers, numbers + 1)
    path = tmp_path / "000000.npz"
    images = np.ones((1, 2, 64, 64, 3), np.uint8)
    Prediction(np.array([0, 1]), np.array([[3, 4]]), images, numbers, 2 * numbers, surprise, every=4).save(path)
    assert not pictures.gone(path)
    pictures.thin_prediction(path)
    found = Prediction.load(path)
    assert (found.image.shape, found.every) == ((0, 2, 64, 64, 3), 4)
    assert pictures.gone(path)
    np.testing.assert_array_equal(found.surprise.kl, surprise.kl)
    np.testing.assert_array_equal(found.repeat, 2 * numbers)
    written = path.read_bytes()
    found.save(path)
    assert Prediction.load(path).metrics() == found.metrics()
    pictures.thin_prediction(path)
    assert len(path.read_bytes()) <= 2 * len(written)
