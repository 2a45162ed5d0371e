"""The docking client: asks, listens, and does not wait for a dead server for ever.

An actionlib client stays ACTIVE for as long as its killed server says nothing; this one stops the robot
and reports server_lost after `patience` seconds without feedback.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from curionav_cli.robot.docking.action import Base, Code, Feedback, Goal, GoalState


class Server(Protocol):
    """A docking server, here or in another process. code: how the goal ended, None before."""

    code: Code | None
    text: str

    def request(self, goal: Goal) -> GoalState:
        """Take a goal."""

    def cancel(self) -> None:
        """Stop."""

    def tick(self) -> Feedback | None:
        """The newest feedback, None where there is nothing new."""


class Client:
    """patience: seconds; period: seconds between two looks at the server; pause(seconds) waits where time is real."""

    def __init__(self, server: Server, base: Base, patience: float, period: float = 0.1,
                 pause: Callable[[float], object] = lambda seconds: None):
        self.server, self.base, self.patience = server, base, patience
        self.period, self.pause = period, pause

    def pursue(self, goal: Goal, heard: Callable[[Feedback], None]) -> tuple[Code, str]:
        """See a goal to its end: how it ended, and in words. heard: is called with each feedback."""
        if self.server.request(goal) is GoalState.rejected:
            return Code.cancelled, f"there is no dock {goal.dock_id}"
        quiet = 0.0
        while self.server.code is None:
            feedback = self.server.tick()
            quiet = 0.0 if feedback else quiet + self.period
            if feedback:
                heard(feedback)
            elif quiet > self.patience:
                self.server.cancel()
                self.base.halt()
                return Code.server_lost, f"{Code.server_lost.text} for {quiet:.1f} s"
            else:
                self.pause(self.period)
        return self.server.code, self.server.text
