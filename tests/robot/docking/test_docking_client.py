"""The docking client beside a server that dies or stalls, in another process and in real time."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from multiprocessing.connection import Connection

import pytest
from dockside import Dockside

from curionav_cli.robot.docking.action import Code, Feedback, Goal, GoalState, Phase
from curionav_cli.robot.docking.client import DockingClient


def serve(pipe: Connection) -> None:
    """A server that sends feedback ten times a second, until it ends."""
    elapsed = 0.0
    while True:
        pipe.send(Feedback(Phase.approach, "scan", 1, elapsed, (0, 0, 0), 1.0))
        elapsed += 0.1
        time.sleep(0.1)


class RemoteServer:
    """The client's end of a server in another process."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("fork")
        self.pipe, self.other = context.Pipe()
        self.process = context.Process(target=serve, args=(self.other,), daemon=True)
        self.code: Code | None = None
        self.text, self.cancelled = "", False

    def request(self, goal: Goal) -> GoalState:
        self.process.start()
        self.other.close()
        return GoalState.active

    def cancel(self) -> None:
        self.cancelled = True

    def tick(self) -> Feedback | None:
        try:
            return self.pipe.recv() if self.pipe.poll() else None
        except EOFError:  # its end of the pipe is closed
            return None


@pytest.mark.parametrize("blow", [signal.SIGKILL, signal.SIGSTOP])
def test_a_dead_or_stalled_server_is_noticed_within_three_seconds(blow: signal.Signals) -> None:
    robot, server = Dockside(), RemoteServer()
    struck: list[float] = []

    def strike(feedback: Feedback) -> None:
        robot.base.drive(0.01, 0.0, 0.1)  # the robot is on its way
        if feedback.elapsed > 0.25 and not struck:
            struck.append(time.monotonic())
            os.kill(server.process.pid or 0, blow)
    try:
        client = DockingClient(server, robot.base, patience=2.0, pause=time.sleep)
        code, text = client.send_goal_and_wait(Goal(robot.scene.dock), strike)
    finally:
        server.process.kill()
        server.process.join()
    assert code is Code.server_lost and "silent" in text and server.cancelled
    assert time.monotonic() - struck[0] < 3.0 or os.getloadavg()[0] > 2.0  # seconds mean little on a busy machine
    assert robot.base.velocity == (0.0, 0.0)


class StallingServer:
    """A server that is silent after so many ticks."""

    def __init__(self, server, ticks: int):
        self.server, self.left = server, ticks
        self.request, self.cancel = server.request, server.cancel

    @property
    def code(self) -> Code | None:
        return self.server.code

    @property
    def text(self) -> str:
        return self.server.text

    def tick(self) -> Feedback | None:
        self.left -= 1
        return self.server.tick() if self.left > 0 else None


@pytest.mark.parametrize("ticks", [3, 40, 150])
def test_the_watchdog_stops_the_wheels_in_every_phase(ticks: int) -> None:
    robot = Dockside(at=(1.6, 0.2, 90.0))
    received: list[Feedback] = []
    client = DockingClient(StallingServer(robot.server, ticks), robot.base, patience=2.0)
    code, _ = client.send_goal_and_wait(Goal(robot.scene.dock), received.append)
    assert code is Code.server_lost and len(received) == ticks - 1
    assert robot.base.velocity == (0.0, 0.0)


def test_an_unknown_dock_is_answered_at_once() -> None:
    robot = Dockside()
    client = DockingClient(robot.server, robot.base, 2.0)
    code, text = client.send_goal_and_wait(Goal(robot.scene.dock, dock_id="kitchen"), print)
    assert code is Code.cancelled and "kitchen" in text
