"""New against known views, on made-up walks whose answers can be counted by hand."""

from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.records import Episode, Prediction, Surprise
from curionav_cli.results.prediction import novelty
from curionav_cli.results.prediction.novelty import KINDS, Views
from curionav_cli.results.runs import Run
from curionav_cli.storage.run_folder import RunFolder


def test_distance_is_that_to_the_nearest_pose_that_looks_the_same_way():
    rng = np.random.default_rng(0)
    def poses(n):
        return np.column_stack([rng.random((n, 2)), rng.uniform(-9, 9, n)])
    pose, earlier = poses(60), poses(150)
    found = novelty.distance(pose, earlier)
    for one, away in zip(pose, found, strict=True):
        turned = np.abs(np.angle(np.exp(1j * (earlier[:, 2] - one[2]))))
        apart = np.hypot(*(earlier[:, :2] - one[:2]).T)[turned <= novelty.SAME_WAY]
        nearest = apart.min(initial=np.inf)
        assert away == pytest.approx(nearest) if nearest <= 2 * novelty.NEW else away > 2 * novelty.NEW


def test_a_row_holds_the_means_their_ratio_and_the_share_of_pairs_in_order():
    kind = np.array([0, 1, 1, 1, 2, 2, 3, 1])
    away = np.array([9, 0.3, 0.5, 0.0, 0.3, 0.05, 0.15, 9])
    settled = np.array([True] * 7 + [False])
    kl = np.array([50.0, 6, 2, 4, 8, 2, 90, 70])
    rows = novelty.table(Views(away, kind, np.arange(8), settled, np.stack([kl, np.zeros(8)])))
    assert [row["views"] for row in rows] == list(KINDS)
    assert [(row["new"], row["known"]) for row in rows] == [(3, 2), (2, 1), (1, 1), (0, 0)]
    assert rows[1]["kl ratio"] == 1.0 and rows[1]["kl auc"] == 0.5 and rows[1]["reward ratio"] is None
    assert rows[0]["kl new"] == pytest.approx(16 / 3) and rows[0]["kl known"] == 3
    assert rows[0]["kl auc"] == pytest.approx((2 + 1.5 - 1 + 2) / 6)  # 6 and 8 above both, 2 beside 4 and 2
    assert rows[3]["kl ratio"] is None and rows[3]["kl auc"] is None


@pytest.fixture
def a_run(tmp_path, an_episode, a_plan):
    """Three episodes: along a wall, the same again, and a metre further off; the KL is 1, 2 and 6 nats."""
    run = RunFolder(tmp_path / "run")
    run.create("seed: 0\nenv: {name: small_room}\nagent: {name: lbs_dreamer}\nrobot: {name: ideal}\n", {}, {}, a_plan())
    for n, nats in enumerate((1.0, 2.0, 6.0)):
        plain = an_episode(steps=11)
        episode = replace(plain, pose=plain.pose + (n == 2) * np.array([0, 1, 0]), action=np.zeros(11, np.int64),
                          collided=np.zeros(11, bool))
        frame = np.arange(12).reshape(2, 6)
        surprise = Surprise(frame, np.full((2, 6), nats, np.float32), np.full((2, 6), 3, np.float32))
        empty = np.zeros((1, 1), np.float32)
        run.save_episode(n, episode)
        run.save_prediction(n, Prediction(np.array([1]), np.array([[1]]), np.zeros((1, 1, 64, 64, 3), np.uint8),
                                        empty, empty, surprise))
    return Run.open(run.path)


def test_each_episode_is_judged_against_those_before_it(a_run):
    found = novelty.views(a_run)
    rows = novelty.table(found)
    # first frames of an episode have no kind; the second window's first five are not settled
    assert (rows[1]["new"], rows[1]["known"]) == (6, 6)
    assert (rows[1]["kl new"], rows[1]["kl known"], rows[1]["kl ratio"], rows[1]["kl auc"]) == (6, 2, 3, 1)
    assert rows[1]["reward ratio"] == 1 and rows[1]["reward auc"] == 0.5
    assert novelty.by_position(found) == {0: 4, 1: 4, 2: 4, 5: 4}


def test_a_run_without_predictions_has_no_views(tmp_path, a_plan):
    run = RunFolder(tmp_path / "run")
    run.create("seed: 0\nenv: {name: small_room}\nagent: {name: random}\nrobot: {name: ideal}\n", {}, {}, a_plan())
    assert novelty.views(Run.open(run.path)) is None


def test_only_frames_that_are_acted_on_are_views(a_run):
    """Held for three steps: what the second episode acts on, the first has passed by in between."""
    folder = a_run.folder
    folder.config.write_text(folder.config.read_text().replace("{name: lbs", "{action_repeat: 3, name: lbs"))
    for n in range(2):
        episode, one = Episode.load(folder.episode_path(n)), Prediction.load(folder.prediction_paths()[n])
        between = np.arange(12) % 3 > 0
        pose = np.column_stack([between if n == 0 else ~between, *np.zeros((2, 12))]).astype(float)
        folder.save_episode(n, replace(episode, pose=pose))
        frame = 3 * np.arange(4)[None]
        surprise = Surprise(frame, np.ones((1, 4), np.float32), np.ones((1, 4), np.float32))
        replace(one, surprise=surprise, every=3).save(folder.prediction_paths()[n])
    folder.prediction_paths()[2].unlink()
    found = novelty.views(Run.open(folder.path))
    assert found.distance.tolist() == [np.inf] * 4 and found.kind.tolist() == [0, 1, 1, 1]


def test_a_held_action_is_cancelled_if_all_its_steps_are():
    action, collided = np.array([0, 0, 0, 1, 1, 1, 0, 0, 0, 2]), np.array([1, 1, 1, 0, 0, 0, 0, 1, 1, 0], bool)
    kinds = novelty.kinds(action, collided, np.array([0, 3, 6, 9]))
    assert [KINDS[kind] for kind in kinds] == ["all", "cancelled", "turn", "forward"]
