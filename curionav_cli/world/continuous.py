"""The environment with continuous actions: forward speed and turn rate, held for 0.6 s."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gymnasium import spaces

from curionav_cli.constants import STEP_LENGTH
from curionav_cli.world import motion
from curionav_cli.world.env import NavigationEnv, Observation, step_info

SECONDS = 0.6
SPEED, TURN = STEP_LENGTH / SECONDS, 1.0  # at most: metres a second, so that a step is 0.25 m; radians a second
SLACK = 1e-6  # of float32


class ContinuousEnv(NavigationEnv):
    """A NavigationEnv whose action is (forward speed in m/s, turn rate in rad/s), held for 0.6 s.

    The robot follows an arc, whose chord must be free; it turns also where it is blocked. Raises ValueError for an
    action outside of the space.
    """

    def actions(self) -> spaces.Box:
        return spaces.Box(np.array([0.0, -TURN], np.float32), np.array([SPEED, TURN], np.float32))

    def _face_start(self) -> None:
        super()._face_start()
        self._yaw = float(motion.YAW[self._heading])

    def _move(self, action: Any) -> bool:
        plan, values = self.now.plan, np.asarray(action, np.float64)
        if values.shape != (2,) or not (-SLACK <= values[0] <= SPEED + SLACK and abs(values[1]) <= TURN + SLACK):
            raise ValueError(f"action {action!r} is no forward speed from 0 to {SPEED:.4f} m/s and turn rate from "
                             f"-{TURN:g} to {TURN:g} rad/s")
        speed, rate = float(values[0].clip(0.0, SPEED)), float(values[1].clip(-TURN, TURN))
        turned = rate * SECONDS
        chord, course = speed * SECONDS * float(np.sinc(turned / (2 * math.pi))), self._yaw + turned / 2
        self._x, self._y, collided = motion.moved(
            plan.visitable, plan.cell, self._x, self._y, chord * math.cos(course), chord * math.sin(course),
            self.scene.collision)
        self._yaw = (self._yaw + turned) % (2 * math.pi)
        return collided

    def _observe(self) -> Observation:
        image, depth = self._renderer.look(self._x, self._y, self._yaw)
        return {"image": image[0], "depth": depth[0]}

    def panorama(self, views: int = 4) -> Observation:
        """Render `views` directions all around, the first ahead, as NavigationEnv does."""
        self.counter.require()
        return self.look(*np.broadcast_arrays(self._x, self._y, self._yaw + np.arange(views) * 2 * np.pi / views))

    def _info(self, collided: bool) -> dict[str, Any]:
        return step_info((self._x, self._y, self._yaw), collided, self.counter.episode)
