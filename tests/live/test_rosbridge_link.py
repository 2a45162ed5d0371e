"""The transport over rosbridge, against a server of this test: what a lost connection and a hanging server do."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from autobahn.twisted.websocket import WebSocketServerFactory, WebSocketServerProtocol
from twisted.internet import reactor, threads

from curionav_cli.live.messages import twist
from curionav_cli.live.rosbridge import Rosbridge
from curionav_cli.robot.docking.action import GoalState

KIND = "geometry_msgs/msg/Twist"


class Server:
    """A rosbridge server that keeps what it hears and can be switched off. port: the same each time."""

    def __init__(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = int(free.getsockname()[1])
        self.heard: list[dict[str, Any]] = []
        self.protocols: list[WebSocketServerProtocol] = []
        self._listening: Any = None

    def start(self) -> None:
        server = self

        class Bridge(WebSocketServerProtocol):
            def onOpen(self) -> None:
                server.protocols.append(self)

            def onMessage(self, payload: bytes, isBinary: bool) -> None:
                server.heard.append(json.loads(payload))
        factory = WebSocketServerFactory()
        factory.protocol = Bridge
        self._listening = threads.blockingCallFromThread(
            reactor, reactor.listenTCP, self.port, factory, interface="127.0.0.1")

    def stop(self) -> None:
        """Drop every connection and listen no more."""
        threads.blockingCallFromThread(reactor, self._listening.stopListening)
        for protocol in self.protocols:
            reactor.callFromThread(protocol.transport.abortConnection)
        self.protocols.clear()

    def send(self, **message: Any) -> None:
        reactor.callFromThread(self.protocols[-1].sendMessage, json.dumps(message).encode())

    def of(self, operation: str) -> list[dict[str, Any]]:
        return [message for message in self.heard if message["op"] == operation]

    @property
    def speeds(self) -> list[float]:
        return [message["msg"]["linear"]["x"] for message in self.of("publish")]


def until(ready: Callable[[], object], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not ready():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture
def server() -> Iterator[Server]:
    if not reactor.running:
        threading.Thread(target=reactor.run, args=(False,), daemon=True).start()
        until(lambda: reactor.running)
    made = Server()
    made.start()
    yield made
    made.stop()


@pytest.fixture
def link(server: Server) -> Iterator[Rosbridge]:
    made = Rosbridge("127.0.0.1", server.port, 2, 20.0)
    yield made
    made.close()


def test_commands_of_a_lost_connection_never_arrive(server: Server, link: Rosbridge) -> None:
    """Neither those published while nobody listens, nor those while a server accepts and does not answer."""
    link.advertise("/cmd_vel", KIND)
    link.publish("/cmd_vel", twist(0.1, 0.0, False, 0.0, 2))
    until(lambda: server.speeds == [0.1])
    server.stop()
    until(lambda: not link.is_alive())
    link.publish("/cmd_vel", twist(0.2, 0.0, False, 0.0, 2))
    with socket.create_server(("127.0.0.1", server.port)) as hanging:
        accepted, _ = hanging.accept()  # TCP is there again, the handshake is not answered
        with accepted:
            until(lambda: link.ros.is_connected)
            assert not link.is_alive()
            link.publish("/cmd_vel", twist(0.3, 0.0, False, 0.0, 2))
            goal = link.action("/drive_distance", "irobot_create_msgs/action/DriveDistance", {"distance": 0.25})
            assert goal.state is GoalState.lost
    server.heard = [message for message in server.heard if message["op"] == "publish"]
    server.start()
    until(link.is_alive)
    link.publish("/cmd_vel", twist(0.4, 0.0, False, 0.0, 2))
    until(lambda: 0.4 in server.speeds)
    assert [message["op"] for message in server.heard[:2]] == ["publish", "advertise"]  # before it is published to
    assert server.speeds == [0.1, 0.4] and not server.of("send_action_goal")


def test_the_last_command_has_arrived_when_the_connection_is_closed(server: Server) -> None:
    link = Rosbridge("127.0.0.1", server.port, 2, 20.0)
    link.advertise("/cmd_vel", KIND)
    link.publish("/cmd_vel", {**twist(0.2, 0.0, False, 0.0, 2), "ballast": "x" * 1_000_000})
    link.publish("/cmd_vel", twist(0.0, 0.0, False, 0.0, 2))
    link.close()
    assert server.speeds == [0.2, 0.0] and not link.is_alive()


def test_what_the_server_refuses_is_kept_and_nothing_is_published_there(server: Server, link: Rosbridge) -> None:
    link.advertise("/cmd_vel", KIND)
    until(lambda: server.of("advertise"))
    server.send(op="status", level="error", msg="another type", id=server.of("advertise")[0]["id"])
    until(lambda: link.complaint("/cmd_vel") == "another type")
    link.publish("/cmd_vel", twist(0.1, 0.0, False, 0.0, 2))
    link.advertise("/other", KIND)
    until(lambda: len(server.of("advertise")) == 2)
    assert not server.speeds and link.complaint("/other") == ""


class Working:
    """Work that the test ends."""

    def __init__(self) -> None:
        self.state, self.text, self.result = GoalState.active, "", {"is_docked": True}

    def cancel(self) -> None:
        self.state = GoalState.preempted


def test_an_action_that_is_offered_answers_and_is_offered_again(server: Server, link: Rosbridge) -> None:
    works: list[Working] = []

    def take(goal: dict[str, Any]) -> Working:
        works.append(Working())
        return works[-1]
    link.offer("/dock", "irobot_create_msgs/action/Dock", take)
    until(lambda: server.of("advertise_action"))
    for name, status in (("one", 4), ("two", 6), ("three", 5)):
        server.send(op="send_action_goal", id=name, action="/dock", args={})
        until(lambda: len(works) == len(server.of("action_result")) + 1)
        if status == 5:
            server.send(op="cancel_action_goal", id=name, action="/dock")
        else:
            works[-1].state = GoalState.succeeded if status == 4 else GoalState.aborted
        until(lambda: len(server.of("action_result")) == len(works))
        answer = server.of("action_result")[-1]
        assert (answer["id"], answer["status"], answer["values"]) == (name, status, {"is_docked": True})
    server.stop()
    until(lambda: not link.is_alive())
    server.start()
    until(lambda: len(server.of("advertise_action")) == 2)
