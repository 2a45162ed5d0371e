"""The Kobuki's alignment drive: from the receivers' bits to wheel speeds, ten times a second.

States and speeds as the maker's driver has them (kobuki_auto_docking): turn until the centre receiver sees the dock's
middle sector; if a whole turn shows only a side sector, turn until the side receiver sees it and drive across to the
middle; then follow the middle sector to contact. As in the maker's driver it has no time limit, so without light it
turns for ever; the server's limits end that.
"""

from __future__ import annotations

import math
from enum import Enum

from curionav_cli.robot.docking_settings import Approach as Speeds
from curionav_cli.robot.measurements import CENTRE, LEFT, NEAR, RIGHT, Signals

BACKING = 10  # ticks
BACK = 0.05  # m/s


class State(Enum):
    """The states of the alignment drive, by the names of kobuki_auto_docking."""

    scan = "scan"
    find_stream = "find_stream"
    get_stream = "get_stream"
    aligned_far = "aligned_far"
    aligned_near = "aligned_near"
    bumped = "bumped"


class Approach:
    """The alignment drive as a state machine. speeds: m/s and rad/s."""

    def __init__(self, speeds: Speeds):
        self.speeds = speeds
        self.restart()

    def restart(self) -> None:
        """Begin with a scan."""
        self.state, self.turned, self._votes, self._backing = State.scan, 0.0, 0, 0

    def bump(self) -> None:
        """Back off after a contact without current, then scan again."""
        self.state, self._backing = State.bumped, BACKING

    @property
    def side(self) -> int:
        """+1 while the dock's left sector was seen more often during this turn, -1 for its right one, else 0."""
        return (self._votes > 0) - (self._votes < 0)

    def tick(self, signals: Signals, turned: float) -> tuple[float, float]:
        """The next command (m/s, rad/s). signals: infrared bits; turned: radians since the last tick, by the gyro."""
        if self.state is State.bumped:
            self._backing -= 1
            if self._backing < 0:
                self.restart()
            return -BACK, 0.0
        self.turned += turned
        return getattr(self, f"_{self.state.value}")(*signals)

    def _scan(self, right: int, centre: int, left: int) -> tuple[float, float]:
        if centre & CENTRE:
            return self._follow(centre)
        self._votes += bool(centre & LEFT) - bool(centre & RIGHT)
        if abs(self.turned) > 2.0 * math.pi:
            self.turned = 0.0
            if self.side:
                self.state = State.find_stream
        return 0.0, self.speeds.crawl if centre else self.speeds.scan

    def _find_stream(self, right: int, centre: int, left: int) -> tuple[float, float]:
        """Turn until the dock lies on the side where the way to its middle begins."""
        if self._sideways(right, left) & (LEFT if self.side > 0 else RIGHT):
            self.state = State.get_stream
            return self.speeds.stream, 0.0
        return 0.0, self.side * self.speeds.find

    def _get_stream(self, right: int, centre: int, left: int) -> tuple[float, float]:
        if self._sideways(right, left) & CENTRE:
            self.restart()
        return self.speeds.stream, 0.0

    def _sideways(self, right: int, left: int) -> int:
        return right if self.side > 0 else left

    def _aligned_far(self, right: int, centre: int, left: int) -> tuple[float, float]:
        return self._follow(centre)

    def _aligned_near(self, right: int, centre: int, left: int) -> tuple[float, float]:
        return self._follow(centre)

    def _follow(self, centre: int) -> tuple[float, float]:
        """Along the middle sector, steering towards it from a side one; out of the light, scan again."""
        if not centre:
            self.restart()
            return 0.0, 0.0
        near = bool(centre & NEAR)
        self.state = State.aligned_near if near else State.aligned_far
        speed, turn = (self.speeds.near, self.speeds.near_turn) if near else (self.speeds.far, self.speeds.far_turn)
        aside = 0 if centre & CENTRE else bool(centre & LEFT) - bool(centre & RIGHT)
        return speed, aside * turn
