"""The transport without a network: topics and actions of objects in this process, for tests and demonstrations."""

from __future__ import annotations

from curionav_cli.live.transport import Callback, Goal, Message, Server


class Memory:
    """transport.Transport in memory. offered: topics that the other side sends, name to type; told: whether it says so.

    send(topic, message) is what the other side does; heard[topic] are the messages that were published to it.
    """

    def __init__(self, offered: dict[str, str], servers: dict[str, Server] | None = None, told: bool = True):
        self.offered, self.servers, self.told = offered, servers or {}, told
        self.subscribers: dict[str, list[Callback]] = {}
        self.advertised: dict[str, str] = {}
        self.heard: dict[str, list[Message]] = {}
        self.listeners: dict[str, Callback] = {}
        self.alive, self.closed = True, False

    def send(self, topic: str, message: Message) -> None:
        """Deliver a message from the other side."""
        for callback in self.subscribers.get(topic, []) if self.alive else []:
            callback(message)

    def advertise(self, topic: str, kind: str) -> None:
        self.advertised[topic] = kind

    def publish(self, topic: str, message: Message) -> None:
        assert topic in self.advertised, topic
        if not self.alive:
            return
        self.heard.setdefault(topic, []).append(message)
        if topic in self.listeners:
            self.listeners[topic](message)

    def subscribe(self, topic: str, kind: str, callback: Callback, newest: bool = False) -> None:
        if self.offered.get(topic, kind) == kind:  # a bridge refuses another type
            self.subscribers.setdefault(topic, []).append(callback)

    def call(self, service: str, kind: str, request: Message, timeout: float) -> Message:
        raise TimeoutError(f"{service}: there are no services in memory")

    def action(self, name: str, kind: str, goal: Message) -> Goal:
        return self.servers[name](goal)

    def offer(self, name: str, kind: str, server: Server) -> None:
        raise NotImplementedError(f"{name}: actions are offered by OtherSide")

    def topics(self) -> dict[str, str]:
        return dict(self.offered) if self.told else {}

    def actions(self) -> list[str] | None:
        return list(self.servers) if self.told else None

    def complaint(self, name: str) -> str:
        return ""

    def is_alive(self) -> bool:
        return self.alive

    def close(self) -> None:
        self.closed, self.alive = True, False


class OtherSide:
    """transport.Transport of the robot behind a Memory: what it publishes is delivered to the subscribers there."""

    def __init__(self, link: Memory):
        self.link = link

    def advertise(self, topic: str, kind: str) -> None:
        self.link.offered[topic] = kind

    def publish(self, topic: str, message: Message) -> None:
        assert topic in self.link.offered, topic
        self.link.send(topic, message)

    def subscribe(self, topic: str, kind: str, callback: Callback, newest: bool = False) -> None:
        self.link.offered[topic] = kind
        self.link.listeners[topic] = callback

    def call(self, service: str, kind: str, request: Message, timeout: float) -> Message:
        return self.link.call(service, kind, request, timeout)

    def action(self, name: str, kind: str, goal: Message) -> Goal:
        return self.link.action(name, kind, goal)

    def offer(self, name: str, kind: str, server: Server) -> None:
        self.link.servers[name] = server

    def topics(self) -> dict[str, str]:
        return {}

    def actions(self) -> list[str] | None:
        return self.link.actions()

    def complaint(self, name: str) -> str:
        return self.link.complaint(name)

    def is_alive(self) -> bool:
        return self.link.is_alive()

    def close(self) -> None:
        self.link.close()
