"""The docking client: sends a goal, follows the feedback, and gives up on a silent server.

An actionlib client stays ACTIVE for ever when its server is killed; this one stops the robot and reports server_lost
after `patience` seconds without feedback.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from curionav_cli.robot.docking.action import Code, Feedback, Goal, GoalState
from curionav_cli.robot.interface import Base


class ActionServer(Protocol):
    """A docking server, in this process or another. code: how the goal ended, None before; text: in words."""

    code: Code | None
    text: str

    def request(self, goal: Goal) -> GoalState:
        """Accept or reject a goal."""

    def cancel(self) -> None:
        """Cancel the goal and stop."""

    def tick(self) -> Feedback | None:
        """The newest feedback, None where there is nothing new."""


class DockingClient:
    """The client. patience: seconds without feedback; period: seconds between polls; pause(seconds): waits."""

    def __init__(self, server: ActionServer, base: Base, patience: float, period: float = 0.1,
                 pause: Callable[[float], object] = lambda seconds: None):
        self.server, self.base, self.patience = server, base, patience
        self.period, self.pause = period, pause

    def send_goal_and_wait(self, goal: Goal, on_feedback: Callable[[Feedback], None]) -> tuple[Code, str]:
        """Send a goal and wait for its result: (code, the same in words). on_feedback: called with each feedback."""
        if self.server.request(goal) is GoalState.rejected:
            return Code.cancelled, f"there is no dock {goal.dock_id}"
        quiet = 0.0
        while self.server.code is None:
            feedback = self.server.tick()
            quiet = 0.0 if feedback else quiet + self.period
            if feedback:
                on_feedback(feedback)
            elif quiet > self.patience:
                self.server.cancel()
                self.base.halt()
                return Code.server_lost, f"{Code.server_lost.text} for {quiet:.1f} s"
            else:
                self.pause(self.period)
        return self.server.code, self.server.text
