"""Where a prediction is wrong because an object moved (paper, section "Qualitative results", red circles).

A world model's pictures are blurred, so they differ from the truth along every edge. Three things set a moved
object apart. Its difference has one sign over an area, so that it outlives smoothing, which cancels the two
sides of a blurred edge. It is larger than is usual in this run so many steps ahead, and in the rest of the same
picture: where all is guessed wrong, no object is to blame. And it lies where an object of the episode's events
stood or stands.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import cv2
import numpy as np

SMOOTHING = 2.0  # pixels
USUAL = 0.9  # of all pixels differ by less than what is called usual
UNUSUAL = 1.75  # times the usual difference
FAINT = 0.05  # of the range of brightness: less is invisible
LEAST_AREA = 20  # pixels
APART = 4  # pixels; regions that are nearer to each other than twice this are one, as a chair's back and seat
HALF_WIDTH, TALL = 0.4, 0.9  # metres, of a box around any chair or cardboard box
NEAREST = 0.3  # metres in front of the camera; what is nearer is not seen whole


class Camera(NamedTuple):
    """A level camera: metres above the floor, tangent of half its field of view."""

    height: float
    tangent: float


class Ellipse(NamedTuple):
    """Around a region of a picture: centre and extent, x to the right and y downward, in pixels."""

    x: float
    y: float
    width: float
    height: float


def difference(predicted: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Smooth the difference of pictures (F, H, W, 3) uint8 -> (F, H, W), 1 from black to white.

    What the whole picture has in common, as a change of the light, is taken off.
    """
    signed = (predicted.astype(np.float32) - truth) / 255
    signed -= np.median(signed, axis=(1, 2), keepdims=True)
    return np.stack([np.sqrt(np.square(cv2.GaussianBlur(one, (0, 0), SMOOTHING)).mean(-1)) for one in signed])


def usual(differences: np.ndarray) -> float:
    """The difference that nine in ten pixels of a run's pictures stay below: (N, H, W) -> one number."""
    return float(np.quantile(differences, USUAL))


def places(events: Iterable[dict[str, Any]]) -> list[tuple[float, float]]:
    """Old and new places of the objects that moved, in metres."""
    return [tuple(event[end]) for event in events if event["what"] == "move" for end in ("from", "to")]


def around(places: Iterable[tuple[float, float]], pose: np.ndarray, camera: Camera, side: int) -> np.ndarray:
    """Mask the pixels (side, side) bool where an object at one of these places is visible from a pose (x, y, yaw)."""
    mask = np.zeros((side, side), bool)
    x, y, yaw = pose
    for east, north in places:
        ahead = (east - x) * math.cos(yaw) + (north - y) * math.sin(yaw)
        right = (east - x) * math.sin(yaw) - (north - y) * math.cos(yaw)
        if ahead < NEAREST:
            continue
        scale = side / 2 / (ahead * camera.tangent)  # pixels a metre
        across = side / 2 + scale * np.array([right - HALF_WIDTH, right + HALF_WIDTH])
        down = side / 2 + scale * (camera.height + np.array([-TALL, 0.0]))
        (left, end), (top, bottom) = (np.clip(np.rint(edges), 0, side).astype(int) for edges in (across, down))
        mask[top:bottom, left:end] = True
    return mask


def regions(difference: np.ndarray, usual: float, near: np.ndarray) -> list[np.ndarray]:
    """Find masks (H, W) of the unusual regions of a difference (H, W) among the pixels `near` moved objects."""
    rest = difference[~near]
    here = float(np.quantile(rest, USUAL)) if rest.size > LEAST_AREA else 0.0
    unusual = near & (difference > max(UNUSUAL * max(usual, here), FAINT))
    reach = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * APART + 1, 2 * APART + 1))
    count, labels = cv2.connectedComponents(cv2.dilate(unusual.astype(np.uint8), reach))
    found = [unusual & (labels == n) for n in range(1, count)]
    return [region for region in found if region.sum() >= LEAST_AREA]


def ellipse(region: np.ndarray) -> Ellipse:
    """Ellipse around a mask (H, W), a little wider than it."""
    (top, left), (bottom, right) = np.argwhere(region).min(0), np.argwhere(region).max(0) + 1
    return Ellipse((left + right) / 2, (top + bottom) / 2, 1.2 * (right - left) + 3, 1.2 * (bottom - top) + 3)
