"""The views whose changes C-BET counts: the robot's own image, or a panorama that only a simulator can take.

A view of an episode is (images, which): distinct images (U, views, 64, 64, 3) uint8, and for each of the N + 1 frames
the index of its own (N + 1,). Frames of one index need not be compared: their change is zero.
"""

from __future__ import annotations

import numpy as np

from curionav_cli.agents.cbet.transitions import Transitions
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene

FRAMES = 8  # panoramas rendered at once
COMPASS = 4

View = tuple[np.ndarray, np.ndarray]


class Ego:
    """The robot's own camera."""

    views = 1

    def __call__(self, transitions: Transitions) -> View:
        """Every frame's own image: U = N + 1, views = 1."""
        return transitions.episode.image[:, None], np.arange(len(transitions) + 1)


class Panorama:
    """Four images from the robot's position, at absolute yaw 0, 90, 180 and 270 degrees, so that turning changes none.

    Privileged: it needs a camera in four directions and a compass. Rendered once for each position.
    """

    views = COMPASS

    def __init__(self, scene: Scene, engine: str, seed: int):
        self.scene, self.seed = scene, seed
        self.renderer = Renderer(scene, engine)

    def __call__(self, transitions: Transitions) -> View:
        """The four images of each of U positions: views = 4."""
        self.renderer = self.renderer.showing(self.scene.at(transitions.index, self.seed)[0])
        places, which = np.unique(transitions.episode.pose[:, :2], axis=0, return_inverse=True)
        parts = [places[at:at + FRAMES] for at in range(0, len(places), FRAMES)]
        heading = np.zeros(FRAMES, np.int64)
        images = [self.renderer.panorama(part[:, 0], part[:, 1], heading[:len(part)], COMPASS)[0] for part in parts]
        return np.concatenate(images), which.ravel()
