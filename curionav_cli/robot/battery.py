"""A battery that holds seconds of driving."""

from __future__ import annotations

from curionav_cli.robot.settings import Battery as Settings


class Battery:
    """left: seconds of driving left, of `capacity`."""

    def __init__(self, settings: Settings):
        self.capacity, self.reserve = settings.capacity, settings.reserve
        self.left = settings.capacity

    @property
    def empty(self) -> bool:
        return self.left <= 0.0

    @property
    def low(self) -> bool:
        """Is no more left than what is kept to go home with?"""
        return self.left <= self.reserve + 1e-6

    def drain(self, seconds: float) -> None:
        self.left = max(0.0, self.left - seconds)

    def charge(self) -> None:
        self.left = self.capacity
