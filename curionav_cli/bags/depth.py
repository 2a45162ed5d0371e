"""Depth of stored episodes, which hold none: a simulated world is drawn again from the poses."""

from __future__ import annotations

import numpy as np

from curionav_cli.constants import HEADINGS, TURN_ANGLE
from curionav_cli.records import Episode
from curionav_cli.world.motion import YAW
from curionav_cli.world.render.renderer import Renderer
from curionav_cli.world.scene.scene import Scene

BATCH = 64  # poses drawn at once


class Redrawn:
    """Draws the episodes of a run again. scene: the run's; seed: of the run, by which furniture and light change."""

    def __init__(self, scene: Scene, seed: int, engine: str):
        self.scene, self.seed, self.renderer = scene, seed, Renderer(scene, engine)

    def depth(self, episode: Episode, number: int) -> np.ndarray | None:
        """Depth (T+1, 64, 64) float32, metres, of episode `number`; None where what is drawn is not what was stored."""
        now, _ = self.scene.at(number, self.seed)
        renderer = self.renderer.showing(now)
        found = np.empty(episode.image.shape[:3], np.float32)
        for first in range(0, len(found), BATCH):
            part = slice(first, first + BATCH)
            image, found[part] = drawn(renderer, episode.pose[part])
            if not np.array_equal(image, episode.image[part]):
                return None
        return found


def drawn(renderer: Renderer, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Image and depth from poses (n, 3), as the environment draws them: by heading where all are exact ones."""
    x, y, yaw = pose.T
    heading = np.round(yaw / TURN_ANGLE).astype(np.int64) % HEADINGS
    if np.array_equal(YAW[heading], yaw):
        return renderer.render(x, y, heading)
    return renderer.look(x, y, yaw)
