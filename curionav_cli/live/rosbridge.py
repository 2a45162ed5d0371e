"""The transport over a rosbridge server, ROS 1 or 2, by roslibpy (the extra `ros`); no ROS on this machine."""

from __future__ import annotations

import threading
import time
from typing import Any

import roslibpy
from roslibpy.core import GoalStatus, RosTimeoutError, ServiceException
from roslibpy.ros1 import actionlib

from curionav_cli.live.action_server import ActionServer
from curionav_cli.live.transport import Callback, Goal, Message, Server
from curionav_cli.robot.docking.action import GoalState

ASKING = 3.0  # seconds to wait for the server's own services
CLOSING = 2.0  # seconds
LASTING = ("advertise", "subscribe", "advertise_action", "send_action_goal")  # refused once, refused until the end
RETRY = 2.0  # seconds between two attempts to connect again, at most
STATES_2 = {
    GoalStatus.ACCEPTED: GoalState.active, GoalStatus.EXECUTING: GoalState.active,
    GoalStatus.CANCELING: GoalState.preempting, GoalStatus.SUCCEEDED: GoalState.succeeded,
    GoalStatus.CANCELED: GoalState.preempted, GoalStatus.ABORTED: GoalState.aborted, GoalStatus.UNKNOWN: GoalState.lost,
}
STATES_1 = dict(enumerate((
    GoalState.pending, GoalState.active, GoalState.preempted, GoalState.succeeded, GoalState.aborted,
    GoalState.rejected, GoalState.preempting, GoalState.preempting, GoalState.preempted, GoalState.lost)))


class Rosbridge:
    """transport.Transport by roslibpy. ros: 1 or 2. Raises TimeoutError where no server answers in `seconds`."""

    def __init__(self, host: str, port: int, ros: int, seconds: float):
        self.version = ros
        self._published: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self.ros = roslibpy.Ros(host, port)
        self.ros.factory.maxDelay = RETRY
        self._complaints: dict[str, tuple[str, str]] = {}  # name: operation, and what the server says
        self.ros.on("status", self._take_status)
        self._open = False
        self.ros.on("ready", self._begin)
        self.ros.on("close", self._end)
        try:
            self.ros.run(seconds)
        except RosTimeoutError as error:
            self.ros.factory.stopTrying()
            raise TimeoutError(str(error)) from error
        self._open = bool(self.ros.is_connected)

    def _begin(self, protocol: object) -> None:
        """Announce at a new connection what is published; roslibpy does so a second later, and the server refuses what
        comes before."""
        self._complaints.clear()
        for topic, published in list(self._published.items()):
            announced = {"op": "advertise", "topic": topic, "type": published.message_type}
            self.ros.send_on_ready(roslibpy.Message(announced))
        self._open = True

    def _end(self, protocol: object) -> None:
        self._open = False

    def advertise(self, topic: str, kind: str) -> None:
        self._published[topic] = roslibpy.Topic(self.ros, topic, kind, queue_size=1)
        self._published[topic].advertise()

    def publish(self, topic: str, message: Message) -> None:
        refused = self._complaints.get(topic, ("", ""))[0] == "advertise"
        if self.is_alive() and not refused:  # else roslibpy keeps it, and an old command would arrive later
            self._published[topic].publish(roslibpy.Message(message))

    def subscribe(self, topic: str, kind: str, callback: Callback, newest: bool = False) -> None:
        roslibpy.Topic(self.ros, topic, kind, queue_length=int(newest)).subscribe(callback)

    def call(self, service: str, kind: str, request: Message, timeout: float) -> Message:
        try:
            return dict(roslibpy.Service(self.ros, service, kind).call(roslibpy.ServiceRequest(request),
                                                                       timeout=timeout))
        except (RosTimeoutError, ServiceException) as error:
            raise TimeoutError(f"{service}: {error}") from error

    def action(self, name: str, kind: str, goal: Message) -> Goal:
        self._complaints.pop(name, None)  # of the goal before
        if not self.is_alive():
            return Unsent()  # as in publish: a move of now must not begin later
        if self.version == 1:
            return Goal1(self._client(name, kind, actionlib.ActionClient), goal)
        return Goal2(self._client(name, kind, roslibpy.ActionClient), goal)

    def offer(self, name: str, kind: str, server: Server) -> None:
        if self.version == 1:
            raise NotImplementedError(f"{name}: actions of ROS 1 are not offered")
        ActionServer(self.ros, name, kind, server)

    def topics(self) -> dict[str, str]:
        try:
            found = self.call("/rosapi/topics", "rosapi/Topics", {}, ASKING)
        except TimeoutError:
            return {}
        return dict(zip(found.get("topics", []), found.get("types", [])))

    def actions(self) -> list[str] | None:
        if self.version == 1:  # there an action is five topics
            ends = "/goal"
            return [topic.removesuffix(ends) for topic in self.topics() if topic.endswith(ends)] or None
        try:
            return list(self.call("/rosapi/action_servers", "rosapi/GetActionServers", {}, ASKING)["action_servers"])
        except (TimeoutError, KeyError):
            return None

    def complaint(self, name: str) -> str:
        return self._complaints.get(name, ("", ""))[1]

    def is_alive(self) -> bool:
        """Return whether messages go out now: with a server that accepts and does not answer, roslibpy keeps them."""
        return self._open and bool(self.ros.is_connected)

    def close(self) -> None:
        """Close the connection. The loop of roslibpy, which cannot be started twice, goes on until the process ends."""
        self.ros.factory.stopTrying()
        self.ros.close()
        until = time.monotonic() + CLOSING  # so that the last command, to stop, is on its way
        while self.is_alive() and time.monotonic() < until:
            time.sleep(0.01)

    def _take_status(self, message: Message) -> None:
        """Keep an error of the server; its id is that of our message, as in advertise:/tf:12."""
        operation, _, rest = str(message.get("id", "")).partition(":")
        if operation in LASTING and message.get("level") == "error":
            self._complaints.setdefault(rest.rpartition(":")[0], (operation, str(message.get("msg", ""))))

    def _client(self, name: str, kind: str, make: Any) -> Any:
        if name not in self._clients:
            self._clients[name] = make(self.ros, name, kind)
        return self._clients[name]


class Unsent:
    """A goal for which there was no connection."""

    state, text = GoalState.lost, "the connection to the robot is lost"

    def cancel(self) -> None:
        """Do nothing."""


class Goal2:
    """A goal of a ROS 2 action."""

    def __init__(self, client: Any, goal: Message):
        self.client, self.state, self.text = client, GoalState.active, ""
        self.id = client.send_goal(roslibpy.Goal(goal), self._result, lambda feedback: None, self._refused)

    def _result(self, result: Any) -> None:
        self.state = STATES_2[result["status"]]

    def _refused(self, result: Any) -> None:
        """Take an answer with result=false: a refused goal, or one that was aborted or cancelled."""
        status = result.get("status", GoalStatus.UNKNOWN) if hasattr(result, "get") else GoalStatus.UNKNOWN
        found = STATES_2.get(status, GoalState.lost)
        self.text = str(result.get("values", "") if hasattr(result, "get") else result)
        self.state = GoalState.rejected if found is GoalState.lost else found

    def cancel(self) -> None:
        if self.client.ros.is_connected:
            self.client.cancel_goal(self.id)


class Goal1:
    """A goal of a ROS 1 action (actionlib)."""

    text = ""

    def __init__(self, client: Any, goal: Message):
        self.goal = actionlib.Goal(client, roslibpy.Message(goal))
        self._ended = threading.Event()
        self.goal.send(lambda result: self._ended.set())

    @property
    def state(self) -> GoalState:
        """The state by the server's status; a goal counts as ended once its result is there."""
        found = STATES_1.get((self.goal.status or {}).get("status", 0), GoalState.lost)
        return found if self._ended.is_set() else GoalState.active

    def cancel(self) -> None:
        if self.goal.action_client.ros.is_connected:
            self.goal.cancel()
