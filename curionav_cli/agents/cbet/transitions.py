"""An episode as rewards use it: N transitions of one environment, the last of them the respawn.

The environments of the released C-BET put the robot back within the step that ends an episode: the policy never
observes the last frame, and transition N - 1 leads from frame N - 1 to the start, with the discount of any other step.
Our start is the episode's own first frame: in a world that does not change it is also the next episode's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from curionav_cli.constants import FORWARD
from curionav_cli.records import Episode

TURNED, MOVED, BLOCKED = 0, 1, 2
KINDS = ("turned", "moved", "blocked")


@dataclass(frozen=True)
class Transitions:
    """The transitions of episode `index` of the run, which belongs to `environment` of E."""

    episode: Episode
    index: int
    environment: int

    def __len__(self) -> int:
        return len(self.episode)

    @property
    def reached(self) -> np.ndarray:
        """The frame that each transition leads to: (N,)."""
        return np.append(np.arange(1, len(self)), 0)

    def poses(self) -> int:
        """Count the different poses that were reached, without that of the respawn."""
        return len(np.unique(self.episode.pose[1:-1], axis=0))

    @property
    def kind(self) -> np.ndarray:
        """The kind of each step (N,): TURNED, MOVED (the position changed) or BLOCKED."""
        moved = (self.episode.pose[1:, :2] != self.episode.pose[:-1, :2]).any(axis=1)
        return np.where(moved, MOVED, np.where(self.episode.action == FORWARD, BLOCKED, TURNED))
