"""Figures of predicted observations: what is drawn is what was stored, the same bytes when drawn again."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.patches import Ellipse

from curionav_cli.records import Prediction, Surprise
from curionav_cli.results import plots
from curionav_cli.results.prediction import plots as prediction_plots
from curionav_cli.results.prediction import stored_predictions
from curionav_cli.results.runs import Run
from curionav_cli.storage.run_folder import RunFolder

STEP = np.array([0, 1, 3, 5])
UNSURPRISED = Surprise(np.zeros((1, 1), np.int64), *np.zeros((2, 1, 1), np.float32))
MOVE = {"what": "move", "item": "chair", "from": [5.0, 0.3], "to": [1.2, 0.3]}


@pytest.fixture
def a_run(tmp_path, an_episode, a_plan):
    """a_run(episodes=7): an agent that predicts what it will see; error n / 1000 in episode n."""
    def make(episodes=7, seed=0, horizon=6, moves=False):
        run = RunFolder(tmp_path / f"run_{seed}")
        run.create(f"seed: {seed}\nenv: {{name: small_room, camera: 0.45, fov: 79}}\nagent: {{name: lbs_dreamer}}\n"
                   "robot: {name: ideal}\n",
                   {}, {}, a_plan())
        for n in range(episodes):
            episode = replace(an_episode(steps=20, seed=n), events=(MOVE,) if moves and n == 4 else ())
            frame = np.array([2, 11])[:, None] + STEP
            image = episode.image[frame].copy()
            if moves and n == 4:
                image[1, 2, 20:44, 26:40] //= 8
            error = np.full((3, horizon), n / 1000, np.float32) + seed
            run.save_episode(n, episode)
            run.save_prediction(n, Prediction(STEP, frame, image, error, 2 * error, UNSURPRISED))
        return Run.open(run.path)
    return make


def test_the_newest_episodes_count_and_their_windows_are_averaged(a_run):
    errors = stored_predictions.errors(a_run())
    np.testing.assert_allclose(errors.predicted, np.repeat([[2], [3], [4], [5], [6]], 6, 1) / 1000, rtol=1e-6)
    assert errors.after(5) == pytest.approx((0.004, 0.008))


def test_over_runs_every_run_is_one_row_as_long_as_the_shortest(a_run):
    both = stored_predictions.over_runs([stored_predictions.errors(a_run()),
                                         stored_predictions.errors(a_run(seed=1, horizon=4))])
    np.testing.assert_allclose(both.predicted, [[0.004] * 4, [1.004] * 4], rtol=1e-6)


def test_a_run_without_predictions_has_none(a_run):
    run = a_run(episodes=0)
    assert stored_predictions.errors(run) is None and stored_predictions.strips(run) == []


def test_real_frames_stand_above_their_predictions(a_run):
    run = a_run()
    strips = prediction_plots.chosen(stored_predictions.strips(run))
    assert [strip.episode for strip in strips] == [6, 6, 5] and not any(any(strip.circles) for strip in strips)
    canvas = prediction_plots.pictures(strips, "title").axes[0].images[0].get_array()
    real = np.load(run.folder.episode_path(6))["image"]
    side, gap, after = prediction_plots.SIDE, prediction_plots.GAP, prediction_plots.BREAK
    left = 2 * (side + gap) + after  # of the third column, three steps ahead
    for row, drawn in ((0, real[strips[0].frame[2]]), (side + gap, strips[0].predicted[2])):
        off = drawn.astype(int) - canvas[row:row + side, left:left + side]
        assert off.min() >= 0 and off.max() < prediction_plots.COARSE


def test_what_an_object_s_move_changed_is_circled_in_both_rows_and_drawn_first(a_run):
    strips = prediction_plots.chosen(stored_predictions.strips(a_run(moves=True)))
    assert [strip.episode for strip in strips] == [4, 6, 6]
    assert [len(circles) for circles in strips[0].circles] == [0, 0, 1, 0] and not any(strips[1].circles)
    figure = prediction_plots.pictures(strips, "title")
    drawn = [patch for patch in figure.axes[0].patches if isinstance(patch, Ellipse)]
    assert len(drawn) == 2 and all(patch.get_edgecolor()[:3] == to_rgb("#dc2626") for patch in drawn)
    (x, upper), (same_x, lower) = (patch.get_center() for patch in drawn)
    column = 2 * (prediction_plots.SIDE + prediction_plots.GAP) + prediction_plots.BREAK
    assert x == same_x == pytest.approx(column + 33, abs=3) and upper == pytest.approx(32, abs=3)
    assert lower - upper == prediction_plots.SIDE + prediction_plots.GAP


def test_an_object_that_was_not_near_is_not_to_blame(a_run):
    run = a_run(moves=True)
    strips = [strip for strip in stored_predictions.strips(run) if strip.episode == 4]
    far = [strip._replace(places=[(5.0, 9.0)]) for strip in strips]
    camera = stored_predictions.moved_objects.Camera(0.45, 0.82)
    for strip in far:
        apart = stored_predictions.moved_objects.difference(strip.predicted, strip.truth)
        assert not any(stored_predictions.circles(strip, apart, [0.0] * 4, camera))


def test_the_curves_are_mean_and_deviation_over_the_rows():
    errors = stored_predictions.Errors(np.array([[0.1, 0.2], [0.3, 0.2]]), np.array([[0.2, 0.6], [0.4, 0.6]]), every=4)
    axes = prediction_plots.error_curve(errors, "lbs_dreamer", "2 seeds", "title").axes[0]
    repeated, ours = axes.lines
    np.testing.assert_allclose(ours.get_ydata(), [0.2, 0.2])
    np.testing.assert_allclose(repeated.get_ydata(), [0.3, 0.6])
    assert ours.get_xdata().tolist() == repeated.get_xdata().tolist() == [4, 8]  # steps of the robot
    band = axes.collections[1].get_paths()[0].vertices[:, 1]
    assert band.min() == pytest.approx(0.2 - np.sqrt(0.02)) and band.max() == pytest.approx(0.2 + np.sqrt(0.02))


def test_drawn_again_they_are_the_same_files(a_run, tmp_path):
    run = a_run(moves=True)
    for turn in ("one", "two"):
        (tmp_path / turn).mkdir()
        strips, errors = prediction_plots.chosen(stored_predictions.strips(run)), stored_predictions.errors(run)
        plots.save(prediction_plots.pictures(strips, "title"), tmp_path / turn / "predictions.png")
        plots.save(prediction_plots.error_curve(errors, run.agent, "5 episodes", "title"),
                   tmp_path / turn / "error.png")
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes()
