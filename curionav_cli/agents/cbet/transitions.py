"""An episode as a reward sees it: N transitions of one environment, the last of them the respawn.

The environments of the released C-BET put the robot back within the step that ends an episode: the policy never
sees the last landing, transition N - 1 leads from frame N - 1 to the start, with the discount of any other step.
Our start is the episode's own first frame: in a world that does not change it is the next one's, too.
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
    """index: which episode of the run; environment: which of the E environments lived it."""

    episode: Episode
    index: int
    environment: int

    def __len__(self) -> int:
        return len(self.episode)

    @property
    def reached(self) -> np.ndarray:
        """(N,) the frame that each transition leads to."""
        return np.append(np.arange(1, len(self)), 0)

    def poses(self) -> int:
        """How many different poses were reached, without the respawn's."""
        return len(np.unique(self.episode.pose[1:-1], axis=0))

    @property
    def kind(self) -> np.ndarray:
        """(N,) TURNED, MOVED (the position changed) or BLOCKED, by what the robot did."""
        moved = (self.episode.pose[1:, :2] != self.episode.pose[:-1, :2]).any(axis=1)
        return np.where(moved, MOVED, np.where(self.episode.action == FORWARD, BLOCKED, TURNED))
