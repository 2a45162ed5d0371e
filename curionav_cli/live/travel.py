"""Motion summed up from odometry and gyro: what was driven since it was last asked."""

from __future__ import annotations

import math
import threading

from curionav_cli.geometry import wrapped
from curionav_cli.live.messages import Odometry, odometry, stamp_of, yaw_rate
from curionav_cli.live.safety import Displaced
from curionav_cli.live.transport import Message
from curionav_cli.robot.measurements import Reading

PAUSE = 0.5  # seconds without a gyro message over which a rate is not carried on
AT_ONCE, FASTEST, SPIN = 0.3, 1.5, 6.0  # metres, m/s and rad/s: motion beyond is a jump of the odometry
RESTART = 1.0  # seconds by which odometry's clock may go back before the base counts as started anew


class Travel:
    """Sums of motion. forward: metres driven, signed; turned: radians to the left by odometry; both since the start.

    now: the newest odometry. Messages that come late are left out. gyro: whether there is one to integrate.
    """

    def __init__(self, gyro: bool):
        self.gyro = gyro
        self.now: Odometry | None = None
        self.forward, self.turned, self.by_gyro = 0.0, 0.0, 0.0
        self._turned_at: float | None = None  # seconds of the last gyro message
        self._read = (0.0, 0.0, 0.0)  # forward, radians, stamp at the last reading
        self._jump = ""
        self._lock = threading.Lock()

    def add_odometry(self, message: Message) -> bool:
        """Take an odometry message; returns whether the base's clock has started anew, so that older stamps lie ahead
        of it."""
        new = odometry(message)
        with self._lock:
            old = self.now
            if old is None:
                self.now, self._read = new, (self.forward, self.heading, new.stamp)
            elif new.stamp > old.stamp:
                self._drive(old, new)
            elif new.stamp < old.stamp - RESTART:
                self._jump = f"the odometry's clock went back by {old.stamp - new.stamp:.1f} s"
                self.now, self._turned_at, self._read = new, None, (self.forward, self.heading, new.stamp)
                return True
        return False

    def _drive(self, old: Odometry, new: Odometry) -> None:
        dx, dy, turn = new.x - old.x, new.y - old.y, wrapped(new.yaw - old.yaw)
        seconds, way, self.now = new.stamp - old.stamp, math.hypot(dx, dy), new
        if way > AT_ONCE + FASTEST * seconds or abs(turn) > AT_ONCE + SPIN * seconds:
            self._jump = f"the odometry jumped by {way:.2f} m and {math.degrees(turn):.0f} degrees in {seconds:.2f} s"
            return
        heading = old.yaw + 0.5 * turn
        self.forward += dx * math.cos(heading) + dy * math.sin(heading)
        self.turned += turn

    def add_gyro(self, message: Message) -> None:
        """Take a message of the gyro: its rate counts for the time since the one before, regular or not."""
        at, rate = stamp_of(message), yaw_rate(message)
        with self._lock:
            last = at if self._turned_at is None else self._turned_at
            if at < last + PAUSE:
                self.by_gyro += rate * max(0.0, at - last)
            self._turned_at = max(at, last)

    def reading(self, bump: str | None = None) -> Reading | None:
        """The motion since the last reading, for the localiser; None where no odometry has come since."""
        with self._lock:
            if self.now is None or self.now.stamp <= self._read[2]:
                return None
            forward, heading, at = self._read
            self._read = (self.forward, self.heading, self.now.stamp)
            return Reading(self.forward - forward, self.heading - heading, self.now.stamp - at, self.now.stamp, bump)

    @property
    def heading(self) -> float:
        """Radians turned to the left since the start, by the gyro where there is one."""
        return self.by_gyro if self.gyro else self.turned

    def check(self) -> None:
        """Raise Displaced, once, after a jump of the odometry."""
        with self._lock:
            what, self._jump = self._jump, ""
        if what:
            raise Displaced(what)
