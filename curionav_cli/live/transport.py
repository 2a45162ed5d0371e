"""What is needed of a connection to a robot. Messages are dictionaries, as rosbridge writes them in JSON."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from curionav_cli.robot.docking.action import GoalState

Message = dict[str, Any]
Callback = Callable[[Message], None]
ENDED = (GoalState.succeeded, GoalState.aborted, GoalState.preempted, GoalState.rejected, GoalState.lost)


class Goal(Protocol):
    """A goal that was sent to an action."""

    @property
    def state(self) -> GoalState:
        """The state, as actionlib has it."""

    @property
    def text(self) -> str:
        """What the server says to it."""

    def cancel(self) -> None:
        """Ask the server to stop."""


class Work(Goal, Protocol):
    """A goal that is carried out on this side. It goes on by itself, and ends in one of ENDED."""

    @property
    def result(self) -> Message:
        """What is answered at its end."""


Server = Callable[[Message], Work]


class Transport(Protocol):
    """A connection to a robot. Callbacks may come from another thread."""

    def advertise(self, topic: str, kind: str) -> None:
        """Announce that messages of type `kind` will be published."""

    def publish(self, topic: str, message: Message) -> None:
        """Send a message to an advertised topic."""

    def subscribe(self, topic: str, kind: str, callback: Callback, newest: bool = False) -> None:
        """Have `callback` called with each message. newest: late ones may be dropped for newer ones."""

    def call(self, service: str, kind: str, request: Message, timeout: float) -> Message:
        """Call a service. Raises TimeoutError without an answer in `timeout` seconds."""

    def action(self, name: str, kind: str, goal: Message) -> Goal:
        """Send a goal."""

    def offer(self, name: str, kind: str, server: Server) -> None:
        """Offer an action: `server` is called with each goal and returns it as it is carried out."""

    def topics(self) -> dict[str, str]:
        """Return the topics that are there, name to type; {} where the other side cannot tell."""

    def actions(self) -> list[str] | None:
        """Return the names of the actions that are there; None where the other side cannot tell."""

    def complaint(self, name: str) -> str:
        """Return what the other side says is wrong with a topic or an action of ours; "" where nothing."""

    def is_alive(self) -> bool:
        """Return whether the connection stands."""

    def close(self) -> None:
        """End the connection."""
