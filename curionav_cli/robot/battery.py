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
        """True when nothing is left."""
        return self.left <= 0.0

    @property
    def low(self) -> bool:
        """True when no more is left than the reserve for the return to dock."""
        return self.left <= self.reserve + 1e-6

    def drain(self, seconds: float) -> None:
        """Take `seconds` of driving."""
        self.left = max(0.0, self.left - seconds)

    def charge(self) -> None:
        """Fill up."""
        self.left = self.capacity
