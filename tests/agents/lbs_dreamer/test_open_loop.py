"""Predictions of an episode not yet learned from: what is stored is what was asked, and nothing else changes."""

import hashlib
from dataclasses import replace

import numpy as np
import pytest
import torch

from curionav_cli.agents.lbs_dreamer import open_loop
from curionav_cli.agents.lbs_dreamer.open_loop import CONTEXT, HORIZON, MEASURED, SHOWN, most_changing
from curionav_cli.records import Prediction


@pytest.fixture
def long(replay):
    return replay(1, 60).episode(0)


def test_the_record_holds_pictures_where_they_belong_and_the_errors_of_all_steps(agent, long):
    seen = agent().predict(3, long)
    assert seen.step.tolist() == [0, 1, 3, 5, 8, 11, 15, 20]
    assert seen.frame.shape == (SHOWN, 8) and seen.image.shape == (SHOWN, 8, 64, 64, 3)
    assert (np.diff(seen.frame, axis=1) == np.diff(seen.step)).all()
    assert (seen.frame[:, 0] >= CONTEXT - 1).all() and seen.frame.max() < len(long.image)
    assert seen.error.shape == seen.repeat.shape == (MEASURED, HORIZON)


def test_the_errors_are_those_of_the_definition(agent, long, monkeypatch):
    grey = np.full((1, 1, 64, 64, 3), 51, np.uint8)
    monkeypatch.setattr(open_loop, "predict", lambda model, image, *rest: np.broadcast_to(grey, image.shape))
    seen = agent().predict(0, long)
    starts = np.linspace(0, len(long.image) - CONTEXT - HORIZON, MEASURED).round().astype(int)
    for window, start in ((0, starts[0]), (7, starts[7]), (15, starts[15])):
        for steps in (1, 5, 20):
            truth = long.image[start + CONTEXT - 1 + steps] / 255
            assert seen.error[window, steps - 1] == pytest.approx(np.mean((truth - 0.2) ** 2), rel=1e-5)
            last = long.image[start + CONTEXT - 1] / 255
            assert seen.repeat[window, steps - 1] == pytest.approx(np.mean((truth - last) ** 2), rel=1e-5, abs=1e-9)
    metrics = seen.metrics()
    assert metrics["open_loop_mse_5"] == pytest.approx(seen.error[:, 4].mean(), rel=1e-6)
    assert metrics["repeat_mse_15"] == pytest.approx(seen.repeat[:, 14].mean(), rel=1e-6) and len(metrics) == 6


def test_what_is_predicted_depends_on_the_context_and_the_actions_alone(agent, long):
    """Frames after the context change nothing; those in it and an action do."""
    made, rng = agent(), np.random.default_rng
    model, device = made.learner.networks.world_model, torch.device("cpu")
    image, action = long.image[None, :12], np.concatenate([[-1], long.action[:11]])[None]
    plain = open_loop.predict(model, image, action, rng(0), device)
    for frames, same in ((slice(CONTEXT, None), True), (slice(0, CONTEXT), False)):
        other = image.copy()
        other[:, frames] = 255 - other[:, frames]
        assert (open_loop.predict(model, other, action, rng(0), device) == plain).all() == same
    turned = action.copy()
    turned[0, 9] = (turned[0, 9] + 1) % 3
    other = open_loop.predict(model, image, turned, rng(0), device)
    assert (other[:, :9] == plain[:, :9]).all() and (other[:, 9:] != plain[:, 9:]).any()


def test_an_action_stands_beside_the_frame_it_led_to(long):
    at = np.array([[0, 1, 2], [7, 8, 9]])
    a = long.action
    assert open_loop.led_to(a, at).tolist() == [[-1, a[0], a[1]], [-1, a[7], a[8]]]


def test_pictures_are_taken_where_most_happens_in_every_part_of_the_episode():
    image = np.zeros((121, 64, 64, 3), np.uint8)
    image[90:96] = np.arange(6, dtype=np.uint8)[:, None, None, None] * 40
    last = 121 - CONTEXT - HORIZON
    start = most_changing(image, last, HORIZON)
    assert (start // 16 == np.arange(6)).all() and start[0] == 0  # nothing happens there: the first
    assert start[4] + CONTEXT <= 91 and start[4] + CONTEXT + HORIZON > 95


def test_the_agent_is_left_as_it_was_and_predicts_the_same_again(agent, replay, long, tmp_path):
    plain, made = agent(), agent()
    first = [made.predict(index, long) for index in (0, 1, 0)]
    for one in (plain, made):
        one.learn(replay(), 2, lambda i: None)
    states = [hashlib.sha256(b"".join(t.numpy().tobytes() for t in one.learner.networks.state_dict().values()))
              for one in (plain, made)]
    assert states[0].digest() == states[1].digest()
    assert plain.rng.bit_generator.state == made.rng.bit_generator.state
    for name, one in zip("abc", first):
        one.save(tmp_path / name)
    a, b, c = ((tmp_path / name).read_bytes() for name in "abc")
    assert a == c != b
    again = Prediction.load(tmp_path / "a")
    for stored, loaded in ((first[0], again), (first[0].surprise, again.surprise)):
        for name, array in vars(stored).items():
            if name != "surprise":
                np.testing.assert_array_equal(array, getattr(loaded, name))


def test_a_short_episode_is_predicted_as_far_as_it_goes(agent, replay):
    short = agent().predict(0, replay(1, 12).episode(0))
    assert short.step.tolist() == [0, 1, 3, 5, 8] and short.error.shape == (MEASURED, 8)
    assert short.metrics().keys() == {f"{name}_mse_{n}" for name in ("open_loop", "repeat") for n in (1, 5)}
    assert agent().predict(0, replay(1, CONTEXT - 1).episode(0)) is None


def test_every_frame_has_a_surprise_that_depends_on_what_came_before_alone(agent, long):
    made = agent()
    found = made.predict(0, long).surprise
    length = made.hyper.sequence_length
    assert found.frame.shape == found.kl.shape == found.reward.shape == (-(-len(long.image) // length), length)
    assert set(found.frame.ravel()) == set(range(len(long.image)))
    assert (np.diff(found.frame, axis=1) == 1).all() and (found.kl >= 0).all() and found.kl.std() > 0
    image = long.image.copy()
    image[30] = 255 - image[30]
    other = made.predict(0, replace(long, image=image)).surprise
    window, place = np.argwhere(found.frame == 30)[0]
    before = np.s_[window, :place]
    assert (other.kl[before] == found.kl[before]).all() and other.kl[window, place] != found.kl[window, place]
    assert other.reward[window, place] == found.reward[window, place]  # expected before the frame was seen


def test_an_agent_that_holds_its_actions_predicts_the_frames_that_it_acts_on(agent, long):
    held = replace(long, action=np.repeat(long.action, 3), image=np.repeat(long.image, 3, 0)[2:],
                   pose=np.repeat(long.pose, 3, 0)[2:], collided=np.repeat(long.collided, 3))
    plain, found = agent().predict(4, long), agent(action_repeat=3).predict(4, held)
    assert (plain.every, found.every) == (1, 3)
    np.testing.assert_array_equal(found.step, 3 * plain.step)
    np.testing.assert_array_equal(found.frame, 3 * plain.frame)
    np.testing.assert_array_equal(found.surprise.frame, 3 * plain.surprise.frame)
    for name in ("image", "error", "repeat"):
        np.testing.assert_array_equal(getattr(found, name), getattr(plain, name))
    assert found.metrics() == plain.metrics()
