"""Actions of ROS 2 that this side offers over rosbridge, which roslibpy 2.1 leaves out (it raises on each goal)."""

from __future__ import annotations

import threading
import time
from typing import Any

import roslibpy
from roslibpy.comm.comm_autobahn import AutobahnRosBridgeClientFactory, AutobahnRosBridgeProtocol
from roslibpy.core import GoalStatus

from curionav_cli.live.transport import ENDED, Message, Server, Work
from curionav_cli.robot.docking.action import GoalState

POLL = 0.02  # seconds
STATUS = {GoalState.succeeded: GoalStatus.SUCCEEDED, GoalState.preempted: GoalStatus.CANCELED}  # others: ABORTED


class Answering(AutobahnRosBridgeProtocol):
    """The protocol of roslibpy that hands goals, cancels and the server's complaints to whoever listens."""

    def __init__(self, *args: Any, **kwargs: Any):
        super().__init__(*args, **kwargs)
        self._message_handlers["status"] = lambda message: self.factory.emit("status", message)

    def _handle_action_request(self, message: Message) -> None:
        self.factory.emit(f"goal {message['action']}", message)

    def _handle_action_cancel(self, message: Message) -> None:
        self.factory.emit(f"cancel {message['action']}", message)


AutobahnRosBridgeClientFactory.protocol = Answering  # of each connection; one that exists cannot be given another


class ActionServer:
    """Offers an action, again after each new connection. server: called with each goal."""

    def __init__(self, ros: roslibpy.Ros, name: str, kind: str, server: Server):
        self.ros, self.name, self.kind, self.server = ros, name, kind, server
        self._working: dict[str, Work] = {}
        ros.on(f"goal {name}", self._take)
        ros.on(f"cancel {name}", self._cancel)
        ros.on("ready", self._advertise)
        if ros.is_connected:
            self._advertise()

    def _advertise(self, protocol: object = None) -> None:
        self._send({"op": "advertise_action", "action": self.name, "type": self.kind,
                    "id": f"advertise_action:{self.name}:{self.ros.id_counter}"})

    def _send(self, message: Message) -> None:
        if self.ros.is_connected:  # a goal ends with its connection
            self.ros.send_on_ready(roslibpy.Message(message))

    def _take(self, message: Message) -> None:
        key = str(message["id"])
        work = self._working[key] = self.server(message.get("args") or {})
        threading.Thread(target=self._answer, args=(key, work), daemon=True).start()

    def _answer(self, key: str, work: Work) -> None:
        """Wait for a goal's end and send its result."""
        while work.state not in ENDED:
            time.sleep(POLL)
        del self._working[key]
        status = STATUS.get(work.state, GoalStatus.ABORTED)
        self._send({"op": "action_result", "action": self.name, "id": key, "values": work.result,
                    "status": status.value, "result": True})

    def _cancel(self, message: Message) -> None:
        work = self._working.get(str(message.get("id")))
        if work:
            work.cancel()
