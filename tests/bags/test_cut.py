"""Moves cut from continuous odometry: the rule of docs/bags.md, on tracks of any shape."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from curionav_cli.bags import cut as cutting
from curionav_cli.bags.cut import BACK, STILL, UNSEEN, cut
from curionav_cli.bags.track import Track
from curionav_cli.constants import FORWARD, LEFT, RIGHT, STEP_LENGTH, TURN_ANGLE


def driven(*legs: tuple[float, float, float], rate: float = 50.0) -> Track:
    """The track of legs (seconds, m/s, degrees/s)."""
    ahead, left = [0.0], [0.0]
    for seconds, speed, turn in legs:
        for _ in range(round(seconds * rate)):
            ahead.append(ahead[-1] + speed / rate)
            left.append(left[-1] + math.radians(turn) / rate)
    forward, turned = np.array(ahead), np.array(left)
    heading = 0.5 * (turned[1:] + turned[:-1])
    x = np.append(0.0, np.cumsum(np.diff(forward) * np.cos(heading)))
    y = np.append(0.0, np.cumsum(np.diff(forward) * np.sin(heading)))
    return Track(np.arange(len(forward)) / rate, np.stack([x, y, turned], axis=-1), forward, turned)


def cut_up(track: Track, images: float = 25.0) -> tuple[list[list[int]], Counter[str], list[cutting.Piece]]:
    left_out: Counter[str] = Counter()
    pieces = cut(track, np.arange(0.0, track.stamp[-1] + 1e-9, 1.0 / images), left_out)
    return [piece.action for piece in pieces], left_out, pieces


@pytest.mark.parametrize(("legs", "actions"), [
    ([(5.0, 0.2, 0.0)], [FORWARD] * 4),
    ([(2.0, 0.0, 45.0)], [LEFT] * 9),
    ([(2.0, 0.0, -45.0)], [RIGHT] * 9),
    ([(2.5, 0.1, 0.0), (1.0, 0.0, 10.0), (2.5, 0.1, 0.0)], [FORWARD, LEFT, FORWARD]),
    ([(2.46, 0.1, 0.0), (1.0, 0.0, 0.0), (0.97, 0.0, 10.0)], [FORWARD, LEFT]),  # stopped a little early
    ([(5.0, 0.2, 5.0)], [FORWARD, LEFT, FORWARD, FORWARD, LEFT, FORWARD]),  # an arc
    ([(1.0, 0.1, 0.0), (1.0, -0.1, 0.0), (2.5, 0.1, 0.0)], [FORWARD]),  # back and again ahead
])
def test_moves_end_after_a_quarter_of_a_metre_or_ten_degrees(legs, actions) -> None:
    found, left_out, _ = cut_up(driven(*legs, (1.0, 0.0, 0.0)))
    assert found == [actions] and not left_out


def test_an_image_shows_the_robot_where_its_move_ended() -> None:
    track = driven((20.0, 0.2, 0.0), (8.0, 0.0, -45.0), (20.0, 0.25, 15.0))
    _, _, (piece,) = cut_up(track)
    assert len(piece.image) == len(piece.action) + 1 and np.all(np.diff(piece.image) > 0)
    counted = np.cumsum([np.zeros(2)] + [
        [STEP_LENGTH * (action == FORWARD), TURN_ANGLE * ((action == LEFT) - (action == RIGHT))]
        for action in piece.action], axis=0)
    at = track.at(np.array(piece.image) / 25.0)
    assert np.abs(at.forward - counted[:, 0]).max() < STEP_LENGTH
    assert np.abs(at.turned - counted[:, 1]).max() < TURN_ANGLE
    np.testing.assert_allclose(piece.pose, at.pose, atol=1e-12)


def test_a_camera_that_is_too_slow_ends_episodes() -> None:
    found, left_out, _ = cut_up(driven((4.0, 0.0, 90.0)), images=2.0)
    assert found == [] and left_out[UNSEEN] >= 4 and left_out[STILL] >= left_out[UNSEEN]


def test_driving_back_ends_an_episode() -> None:
    found, left_out, pieces = cut_up(driven((5.0, 0.2, 0.0), (3.0, -0.2, 0.0), (5.0, 0.2, 0.0)))
    assert found[0] == [FORWARD] * 4 and set(found[-1]) == {FORWARD} and left_out[BACK] == 2
    assert pieces[0].image[-1] < pieces[-1].image[0]


def test_a_long_drive_is_several_episodes_of_adjacent_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cutting, "LONGEST", 6)
    found, left_out, pieces = cut_up(driven((20.0, 0.2, 0.0)))
    assert [len(actions) for actions in found] == [6, 6, 4] and not left_out
    assert [piece.image[-1] for piece in pieces[:2]] == [piece.image[0] for piece in pieces[1:]]


leg = st.tuples(st.floats(0.1, 5.0), st.floats(-0.5, 0.5), st.floats(-90.0, 90.0))


@settings(deadline=None, max_examples=60)
@given(st.lists(leg, min_size=1, max_size=5), st.floats(3.0, 40.0))
def test_any_drive_gives_moves_that_follow_it(legs, rate) -> None:
    """Between two frames of an episode the robot has done what the action says, to less than one move."""
    track = driven(*legs)
    _, _, pieces = cut_up(track, rate)
    for piece in pieces:
        assert len(piece.image) == len(piece.action) + 1 and np.all(np.diff(piece.image) > 0)
        at = track.at(np.array(piece.image) / rate)
        ahead = np.array([action == FORWARD for action in piece.action]) * STEP_LENGTH
        left = np.array([(action == LEFT) - (action == RIGHT) for action in piece.action]) * TURN_ANGLE
        assert np.abs(at.forward - at.forward[0] - np.append(0.0, np.cumsum(ahead)))[1:].max() < 1.6 * STEP_LENGTH
        assert np.abs(at.turned - at.turned[0] - np.append(0.0, np.cumsum(left)))[1:].max() < 1.6 * TURN_ANGLE
