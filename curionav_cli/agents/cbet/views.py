"""What a change is the change of: the picture itself, or a panorama that only a simulator can take.

A view of an episode is (pictures, which): distinct pictures (U, views, 64, 64, 3) uint8, and for each of the
N + 1 frames which of them it shows. Frames that share one need not be compared: their change is zero.
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
    """The one camera of the robot."""

    views = 1

    def __call__(self, life: Transitions) -> View:
        return life.episode.image[:, None], np.arange(len(life) + 1)


class Panorama:
    """Four pictures from where the robot stands, at absolute yaw 0, 90, 180 and 270 degrees, so that turning changes
    none of them. Privileged: a camera that looks four ways at once, and a compass. Rendered once for each position.
    """

    views = COMPASS

    def __init__(self, world: Scene, engine: str, seed: int):
        self.world, self.seed = world, seed
        self.renderer = Renderer(world, engine)

    def __call__(self, life: Transitions) -> View:
        self.renderer = self.renderer.showing(self.world.at(life.index, self.seed)[0])
        places, which = np.unique(life.episode.pose[:, :2], axis=0, return_inverse=True)
        parts = [places[at:at + FRAMES] for at in range(0, len(places), FRAMES)]
        heading = np.zeros(FRAMES, np.int64)
        pictures = [self.renderer.panorama(part[:, 0], part[:, 1], heading[:len(part)], COMPASS)[0] for part in parts]
        return np.concatenate(pictures), which.ravel()
