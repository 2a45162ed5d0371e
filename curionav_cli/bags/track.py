"""The way of a robot by its odometry: stretches without a jump, a silence or a clock that starts anew."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from curionav_cli.live.safety import Displaced
from curionav_cli.live.transport import Message
from curionav_cli.live.travel import Travel

SILENCE = 1.0  # seconds without odometry, over which nobody knows how the robot moved
MOST = 5_000_000  # messages of odometry


@dataclass(frozen=True)
class Track:
    """n poses in the order of time. stamp (n,) seconds; pose (n, 3) x, y (m), yaw (rad, not wrapped) in odometry's
    frame; forward (n,) metres driven, signed; turned (n,) radians to the left, both since the start."""

    stamp: np.ndarray
    pose: np.ndarray
    forward: np.ndarray
    turned: np.ndarray

    def at(self, stamp: np.ndarray) -> Track:
        """The track at other times within it, interpolated."""
        one = lambda values: np.interp(stamp, self.stamp, values)
        return Track(stamp, np.stack([one(column) for column in self.pose.T], axis=-1), one(self.forward),
                     one(self.turned))


class Tracker:
    """Sums up odometry messages. left_out: what could not be used, by what it is."""

    def __init__(self, left_out: Counter[str]):
        self.travel, self.left_out = Travel(gyro=False), left_out
        self._eras: list[list[list[tuple[float, ...]]]] = [[[]]]

    def add(self, message: Message) -> None:
        """Take a message. Raises MessageFault for one that is no odometry."""
        before = self.travel.now
        anew = self.travel.add_odometry(message)
        now = self.travel.now
        assert now is not None
        if now is before:
            self.left_out["late odometry messages"] += 1
            return
        why = self._broken(anew, before.stamp if before else now.stamp, now.stamp)
        if why:
            self.left_out[why] += 1
            if anew:
                self._eras.append([])
            self._eras[-1].append([])
        self._eras[-1][-1].append((now.stamp, now.x, now.y, now.yaw, self.travel.forward, self.travel.turned))

    def _broken(self, anew: bool, before: float, now: float) -> str:
        """Why a new stretch begins, seconds `before` to `now`; empty where it does not."""
        try:
            self.travel.check()
        except Displaced:
            return "restarts of the odometry's clock" if anew else "jumps of the odometry"
        return "silences of the odometry" if now - before > SILENCE else ""

    def eras(self) -> list[list[Track]]:
        """The stretches so far, by how often the odometry's clock had started anew."""
        return [[track(np.array(rows)) for rows in era if len(rows) > 1] for era in self._eras]


def track(rows: np.ndarray) -> Track:
    """The track of rows (n, 6): stamp, x, y, yaw, forward, turned."""
    stamp, x, y, yaw, forward, turned = rows.T
    return Track(stamp, np.stack([x, y, np.unwrap(yaw)], axis=-1), forward, turned)
