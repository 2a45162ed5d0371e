"""Records come back as they were saved; a save is whole or absent, and the same bytes every time."""

import numpy as np
import pytest

from curionav_cli.decisions import Steps
from curionav_cli.errors import RunFolderError
from curionav_cli.records import Episode, FloorPlan, Pose


def test_an_episode_comes_back_as_it_was_and_is_the_same_file_twice(tmp_path, an_episode):
    episode = an_episode(steps=7, events=({"moved": "chair", "from": [1.0, 2.0], "to": [1.5, 2.0]},))
    episode.save(tmp_path / "a.npz")
    episode.save(tmp_path / "b.npz")
    back = Episode.load(tmp_path / "a.npz")
    for key in ("image", "action", "pose", "collided"):
        np.testing.assert_array_equal(getattr(back, key), getattr(episode, key))
    assert back.events == episode.events
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    with np.load(tmp_path / "a.npz") as plain:  # any user's numpy reads it
        assert plain["image"].shape == (8, 64, 64, 3) and plain["pose"].dtype == np.float64


def test_a_write_that_fails_leaves_the_old_file_and_no_litter(tmp_path, an_episode, monkeypatch):
    an_episode(steps=3).save(tmp_path / "a.npz")
    before = (tmp_path / "a.npz").read_bytes()

    def full(_):
        raise OSError(28, "No space left on device")
    monkeypatch.setattr("curionav_cli.files.os.fsync", full)
    with pytest.raises(OSError):
        an_episode(steps=5).save(tmp_path / "a.npz")
    assert (tmp_path / "a.npz").read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


@pytest.mark.parametrize("harm", [lambda b: b[:-40], lambda b: b"", lambda b: b[:200] + b"\0" * 40 + b[240:]])
def test_a_broken_episode_is_named(tmp_path, an_episode, harm):
    path = tmp_path / "000004.npz"
    an_episode(steps=3).save(path)
    path.write_bytes(harm(path.read_bytes()))
    with pytest.raises(RunFolderError, match=r"000004\.npz is not whole"):
        Episode.load(path)


def test_a_pickle_inside_an_episode_is_refused(tmp_path):
    np.savez(tmp_path / "a.npz", image=np.array([{"a": 1}], dtype=object), action=0, pose=0, collided=0, events=0)
    with pytest.raises(RunFolderError, match="not whole"):
        Episode.load(tmp_path / "a.npz")


def test_a_plan_comes_back_and_finds_cells(tmp_path, a_plan):
    plan = a_plan(rows=4, columns=6, cell=0.5)
    plan.save(tmp_path / "plan.npz")
    back = FloorPlan.load(tmp_path / "plan.npz")
    np.testing.assert_array_equal(back.visitable, plan.visitable)
    assert back.start == plan.start and isinstance(back.start, Pose) and back.cell == 0.5
    row, column = back.cells(np.array([0.0, 0.49, 0.5, 2.99, 9.0]), np.array([0.0, 1.99, 0.5, 0.0, -1.0]))
    assert row.tolist() == [0, 3, 1, 0, 0] and column.tolist() == [0, 0, 1, 5, 5]


def test_an_episode_at_the_frames_of_an_agent_that_holds_actions_for_three_steps(an_episode):
    episode = an_episode(steps=11)
    episode.action[:9] = np.repeat([2, 0, 1], 3)  # the last two steps are no whole action
    episode.collided[:] = False
    episode.collided[[4, 10]] = True
    kept = episode.every(Steps(3))
    assert kept.action.tolist() == [2, 0, 1] and kept.collided.tolist() == [False, True, False] and len(kept) == 3
    np.testing.assert_array_equal(kept.image, episode.image[[0, 3, 6, 9]])
    np.testing.assert_array_equal(kept.pose, episode.pose[[0, 3, 6, 9]])
    assert not np.shares_memory(kept.image, episode.image)  # or a replay would hold all of it
    assert episode.every(Steps(1)) is episode
    episode.action[4] = 1
    with pytest.raises(RunFolderError, match=r"without agent\.action_repeat=3: .*Set agent\.action_repeat=1\."):
        episode.every(Steps(3))
