"""The pictures that a robot has seen from where it stands: turning back, or a move that is cancelled, draws none."""

from __future__ import annotations

import numpy as np

from curionav_cli.constants import IMAGE_SIDE

MOST = 2048 * IMAGE_SIDE**2  # pixels of all worlds together, 59 MB; of 64 x 64 a world has 36 headings, 1 MB

Picture = tuple[np.ndarray, np.ndarray]  # image (S, S, 3) uint8, depth (S, S) float32


class Pictures:
    """Keeps the newest pictures of each of E worlds by heading, until `forget`, which is due when anything changes."""

    def __init__(self, worlds: int = 1, side: int = IMAGE_SIDE):
        self._most = max(1, MOST // (worlds * side**2))  # of each world
        self._of: list[dict[int, Picture]] = [{} for _ in range(worlds)]

    def forget(self, world: int = 0) -> None:
        """Drop the pictures of a world that is reset, or whose robot has changed its place."""
        self._of[world].clear()

    def missing(self, worlds: list[int], heading: list[int]) -> list[int]:
        """Those of these worlds that have no picture of their heading. heading: of all worlds."""
        return [world for world in worlds if heading[world] not in self._of[world]]

    def keep(self, world: int, heading: int, image: np.ndarray, depth: np.ndarray) -> None:
        """Keep a copy of a picture; the oldest one makes room."""
        pictures = self._of[world]
        if len(pictures) >= self._most:
            del pictures[next(iter(pictures))]
        pictures[heading] = (image.copy(), depth.copy())

    def one(self, world: int, heading: int) -> dict[str, np.ndarray]:
        """A copy of a picture as an observation. Raises KeyError where it is missing."""
        image, depth = self._of[world][heading]
        return {"image": image.copy(), "depth": depth.copy()}

    def all(self, heading: list[int]) -> dict[str, np.ndarray]:
        """Copies of the pictures of all worlds, (E, ...) each. Raises KeyError where one is missing."""
        seen = [pictures[at] for pictures, at in zip(self._of, heading, strict=True)]
        return {"image": np.stack([image for image, _ in seen]), "depth": np.stack([depth for _, depth in seen])}
