"""robot.dry_run=true: everything is read, nothing is sent, and what would be sent is printed."""

from __future__ import annotations

from collections.abc import Callable

from curionav_cli.live.base import LiveBase
from curionav_cli.live.transport import Callback, Goal, Message, Server, Transport
from curionav_cli.records import DockReport, Pose
from curionav_cli.robot.docking.action import GoalState
from curionav_cli.robot.occupancy import Occupancy


class DryRun:
    """A transport that subscribes and sends nothing. say: prints a line."""

    def __init__(self, inner: Transport, say: Callable[[str], None]):
        self.inner, self.say = inner, say
        self._last: dict[str, Message] = {}

    def advertise(self, topic: str, kind: str) -> None:
        self.say(f"dry run: would advertise {topic} as {kind}")

    def publish(self, topic: str, message: Message) -> None:
        """Print a command, unless it is that before it."""
        body = {key: value for key, value in message.items() if key != "header"}
        if self._last.get(topic) != body:
            self._last[topic] = body
            self.say(f"dry run: would send {topic} {body}")

    def subscribe(self, topic: str, kind: str, callback: Callback, newest: bool = False) -> None:
        self.inner.subscribe(topic, kind, callback, newest)

    def call(self, service: str, kind: str, request: Message, timeout: float) -> Message:
        self.say(f"dry run: would call {service} {request}")
        return {}

    def action(self, name: str, kind: str, goal: Message) -> Goal:
        self.say(f"dry run: would have {name} done {goal}")
        return Done()

    def offer(self, name: str, kind: str, server: Server) -> None:
        self.say(f"dry run: would offer {name} as {kind}")

    def topics(self) -> dict[str, str]:
        return self.inner.topics()

    def actions(self) -> list[str] | None:
        return self.inner.actions()

    def complaint(self, name: str) -> str:
        return self.inner.complaint(name)

    def is_alive(self) -> bool:
        return self.inner.is_alive()

    def close(self) -> None:
        self.inner.close()


class Done:
    """A goal that was never sent."""

    state, text = GoalState.succeeded, "dry run"

    def cancel(self) -> None:
        """Do nothing."""


class StandStill:
    """What Home is to a robot that moves: episodes begin wherever it stands."""

    def __init__(self, base: LiveBase, place: Pose):
        self.base, self.place, self.has_dock = base, place, False

    def begin(self) -> None:
        """Take the present place for the start."""
        self.base.localiser.leave_dock(self.place)

    def come_back(self, occupancy: Occupancy, lost: str = "") -> DockReport:
        """Report that nothing was done."""
        return DockReport(code="dry_run", text="nothing was sent", human=False, attempts=0, recoveries=(), seconds=0.0,
                          metres=0.0, distance=0.0, battery=self.base.battery.left)

    def leave(self) -> None:
        """Do nothing."""
