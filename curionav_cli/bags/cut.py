"""Continuous motion cut into moves of 0.25 m and 10 degrees (docs/bags.md has the rule in words).

A move ends when the robot has driven a step ahead, or turned by an angle, since the last one ended; what it has moved
beyond is counted for the next. Its image is the first one newer than its end, if the robot has by then moved no more
than half a move. Where there is none, or the robot has driven back by a step, the episode ends, and the next begins.
"""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

import numpy as np

from curionav_cli.bags.track import Track
from curionav_cli.constants import FORWARD, LEFT, RIGHT, STEP_LENGTH, TURN_ANGLE

NEAR, NEAR_TURN = 0.01, math.radians(0.5)  # metres and radians that may be left, as bases stop a little early
HALF, HALF_TURN = 0.5 * STEP_LENGTH, 0.5 * TURN_ANGLE
WAIT = 1.0  # seconds from a move's end to its image
LONGEST = 5000  # moves of an episode; longer ones are cut
UNSEEN, BACK, STILL = "moves without an image of their own", "drives back by 0.25 m", "stretches without a move"


class Piece(NamedTuple):
    """An episode of n moves. image (n+1,): which images; action (n,); pose (n+1, 3) by odometry at the images."""

    image: list[int]
    action: list[int]
    pose: np.ndarray


def cut(track: Track, stamp: np.ndarray, left_out: Counter[str]) -> list[Piece]:
    """The episodes of a stretch. stamp (m,): when the images were taken, ascending; left_out is counted up."""
    first, last = np.searchsorted(stamp, track.stamp[0]), np.searchsorted(stamp, track.stamp[-1], side="right")
    seen = track.at(stamp[first:last])
    pieces, begin = [], 0
    while begin < len(seen.stamp):
        images, actions, begin = _piece(track, seen, begin, left_out)
        if actions:
            pieces.append(Piece([first + image for image in images], actions, seen.pose[images]))
        else:
            left_out[STILL] += 1
    return pieces


def _piece(track: Track, seen: Track, begin: int, left_out: Counter[str]) -> tuple[list[int], list[int], int]:
    """Images and actions of the episode that begins at image `begin`, and the image at which the next one may begin."""
    images, actions = [begin], list[int]()
    forward, turned = seen.forward[begin], seen.turned[begin]
    for at in range(int(np.searchsorted(track.stamp, seen.stamp[begin], side="right")), len(track.stamp)):
        ahead, left = track.forward[at] - forward, track.turned[at] - turned
        action = due(ahead, left)
        following = max(images[-1] + 1, int(np.searchsorted(seen.stamp, track.stamp[at])))
        if ahead <= -STEP_LENGTH:
            left_out[BACK] += 1
            return images, actions, following
        if action is None:
            continue
        if not belongs(track, at, seen, following):
            left_out[UNSEEN] += 1
            return images, actions, following
        images.append(following)
        actions.append(action)
        forward += STEP_LENGTH * (action == FORWARD)
        turned += TURN_ANGLE * ((action == LEFT) - (action == RIGHT))
        if len(actions) == LONGEST:
            return images, actions, following
    return images, actions, len(seen.stamp)


def due(ahead: float, left: float) -> int | None:
    """The move that has ended, metres ahead and radians to the left after the one before; None where none has."""
    if ahead >= STEP_LENGTH - NEAR:
        return FORWARD
    if abs(left) >= TURN_ANGLE - NEAR_TURN:
        return LEFT if left > 0.0 else RIGHT
    return None


def belongs(track: Track, at: int, seen: Track, image: int) -> bool:
    """Whether an image shows where the robot stood at pose `at` of the track."""
    return image < len(seen.stamp) and seen.stamp[image] - track.stamp[at] <= WAIT and \
        abs(seen.forward[image] - track.forward[at]) <= HALF and abs(seen.turned[image] - track.turned[at]) <= HALF_TURN
