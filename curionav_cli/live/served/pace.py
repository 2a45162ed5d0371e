"""Served robots in real time, each in a thread of its own, so that one that docks holds up no other."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from curionav_cli.live.served.robot import ServedRobot

BEHIND = 0.5  # seconds of the clock that a robot may lag; what is more is not caught up
NOTED_EVERY = 30.0  # seconds


class Pace:
    """Runs robots at `speed` simulated seconds a second. say: prints a line where the machine is too slow."""

    def __init__(self, robots: list[ServedRobot], speed: float, say: Callable[[str], None]):
        self.robots, self.speed, self.say = robots, speed, say
        self._ended = threading.Event()
        self._failed: list[BaseException] = []

    def run(self, watch: Callable[[], None], period: float = 0.2) -> None:
        """Run until interrupted; `watch` is called every `period` seconds. Raises what a robot raised."""
        threads = [threading.Thread(target=self._run, args=(robot,), daemon=True) for robot in self.robots]
        for thread in threads:
            thread.start()
        try:
            while not self._ended.wait(period):
                watch()
        finally:
            self._ended.set()
            for thread in threads:
                thread.join()
        raise self._failed[0]

    def _run(self, robot: ServedRobot) -> None:
        try:
            self._follow_clock(robot)
        except BaseException as error:
            self._failed.append(error)
            self._ended.set()

    def _follow_clock(self, robot: ServedRobot) -> None:
        began, lost, noted = time.monotonic(), 0.0, 0.0
        while not self._ended.is_set():
            robot.step()
            ahead = robot.time / self.speed - (time.monotonic() - began - lost)
            if ahead < -BEHIND:
                lost += -BEHIND - ahead
                if lost > noted + NOTED_EVERY or not noted:
                    noted = lost
                    share = robot.time / self.speed / (time.monotonic() - began)
                    self.say(f"this machine is too slow: {share:.0%} of the speed. Lower --images or --speed.")
            elif ahead > 0.0:
                self._ended.wait(ahead)
