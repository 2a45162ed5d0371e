"""The newest message of each of a robot's topics, how old it is, and what it says."""

from __future__ import annotations

import math
import threading
from collections import Counter, deque
from functools import partial, reduce
from operator import or_
from typing import NamedTuple

import numpy as np

from curionav_cli.live import contacts, images
from curionav_cli.live.clock import Clock
from curionav_cli.live.messages import laser, stamp_of
from curionav_cli.live.safety import Fault, MessageFault
from curionav_cli.live.settings import Profile, Topic
from curionav_cli.live.transport import Message, Transport
from curionav_cli.live.travel import Travel
from curionav_cli.robot.depth_camera import DepthCamera
from curionav_cli.robot.measurements import Scan, Signals
from curionav_cli.world.render.renderer import FAR

SEEING = ("image", "depth", "scan")  # what a step's observation is made of
AHEAD = math.radians(35.0)  # half of the field in which a scanner stands in for a depth camera
SILENT_ON_DOCK = ("image", "depth", "scan")  # a TurtleBot 4 switches them off there
LIT = 0.4  # seconds over which the dock's light is collected, as the maker's driver does


class Heard(NamedTuple):
    """A message; at: when it arrived on our clock; stamp: its own time on the robot's, 0 without a header."""

    message: Message
    at: float
    stamp: float


class Sensors:
    """What a robot's topics say. namespace: before each name. stale: seconds after which a topic counts as silent."""

    def __init__(self, transport: Transport, profile: Profile, namespace: str, stale: float, clock: Clock,
                 camera: DepthCamera):
        self.profile, self.clock, self.stale, self.camera = profile, clock, stale, camera
        self.transport, self.namespace = transport, namespace
        self.topics = profile.topics()
        self.travel = Travel("imu" in self.topics)
        self.needed = tuple(key for key in ("odom", "imu", *SEEING) if key in self.topics)
        self.touching: dict[str, bool] = {}
        self.received: Counter[str] = Counter()
        self._bumped: set[str] = set()
        self._light: deque[tuple[float, Signals]] = deque()
        self._heard: dict[str, Heard] = {}
        self._broken: MessageFault | None = None
        self._lock = threading.Lock()
        for key, topic in self.topics.items():
            transport.subscribe(full(namespace, topic.name), topic.type, partial(self._hear, key, topic),
                                newest=key in SEEING)

    def _hear(self, key: str, topic: Topic, message: Message) -> None:
        """Take a message, in the transport's thread. One that cannot be used is answered by the next `check`."""
        try:
            self._take(key, topic, message)
        except MessageFault as fault:
            with self._lock:
                self._broken = MessageFault(f"{topic.name} ({topic.type}) sent {fault}")

    def _take(self, key: str, topic: Topic, message: Message) -> None:
        self.received[key] += 1
        stamp = stamp_of(message) if key in self.needed else 0.0
        with self._lock:
            before = self._heard.get(key)
            if before and stamp < before.stamp and key in SEEING:
                return  # it was overtaken
            self._heard[key] = Heard(message, self.clock.now(), stamp)
        if key == "odom":
            self._forget_older(self.travel.add_odometry(message))
        elif key == "imu":
            self.travel.add_gyro(message)
        elif key.startswith("contact"):
            self._touch(contacts.touches(message, topic.type))
        elif key == "dock_ir":
            self._see_light(contacts.dock_light(message, topic.type))

    def _forget_older(self, anew: bool) -> None:
        """Forget what was seen by a clock that is no more."""
        with self._lock:
            for key in SEEING if anew else ():
                self._heard.pop(key, None)

    def _touch(self, found: dict[str, bool]) -> None:
        with self._lock:
            self.touching.update(found)
            self._bumped |= {name for name, touched in found.items() if touched}

    def _see_light(self, seen: Signals) -> None:
        now = self.clock.now()
        with self._lock:
            self._light.append((now, seen))
            while self._light[0][0] < now - LIT:
                self._light.popleft()

    def signals(self) -> Signals:
        """What the infrared receivers have seen of the dock in the last LIT seconds: right, centre, left."""
        since = self.clock.now() - LIT
        with self._lock:
            seen = [frame for at, frame in self._light if at >= since]
        right, centre, left = (reduce(or_, bits, 0) for bits in (zip(*seen) if seen else ((), (), ())))
        return right, centre, left

    def check(self, without: tuple[str, ...] = ()) -> None:
        """Raise Fault for a broken message, a jump of the odometry or a needed topic that is silent."""
        with self._lock:
            broken, self._broken = self._broken, None
        if broken:
            raise broken
        self.travel.check()
        refused = next(filter(self.complaint, self.needed), "")
        if refused:
            topic = self.topics[refused]
            raise MessageFault(f"{topic.name} ({topic.type}) does not reach us{self.complaint(refused)}")
        silent = next((key for key in self.needed if key not in without and self.age(key) > self.stale), "")
        if silent:
            raise Fault(f"{self.topics[silent].name} has been silent for {self._words(silent)} ({silent})")

    def age(self, key: str) -> float:
        """Seconds since the last message arrived; inf before the first."""
        heard = self._heard.get(key)
        return self.clock.now() - heard.at if heard else math.inf

    def complaint(self, key: str) -> str:
        """What the other side says to our subscription, to be added to a line."""
        said = self.transport.complaint(full(self.namespace, self.topics[key].name))
        return f"; the server says: {said}" if said else ""

    def _words(self, key: str) -> str:
        age = self.age(key)
        return f"{age:.1f} s" if math.isfinite(age) else "as long as we listen"

    def seen_since(self, stamp: float) -> bool:
        """Whether everything an observation is made of was taken at or after this time on the robot's clock."""
        return all(key in self._heard and self._heard[key].stamp >= stamp for key in SEEING if key in self.topics)

    def seeing(self) -> bool:
        """Whether everything an observation is made of arrives."""
        return all(self.age(key) <= self.stale for key in SEEING if key in self.topics)

    def bumped(self) -> set[str]:
        """What was touched since this was last asked, and what still is."""
        with self._lock:
            found = self._bumped | {name for name, touched in self.touching.items() if touched}
            self._bumped = set()
        return found

    def image(self) -> np.ndarray:
        """The newest image (64, 64, 3) uint8. Raises MessageFault."""
        return self._decoded(lambda: images.picture(self._message("image"), self.profile.image.type,
                                                    self.profile.image.crop), "image")

    def depth(self) -> np.ndarray:
        """The newest depth (64, 64) float32 metres; FAR everywhere for a robot without a depth camera."""
        if "depth" not in self.topics:
            return np.full((images.IMAGE_SIDE, images.IMAGE_SIDE), FAR, np.float32)
        return self._decoded(lambda: images.depth(self._message("depth"), self.profile.depth.type,
                                                  self.profile.depth.crop), "depth")

    def ahead(self) -> Scan:
        """What stands ahead: of the depth image, or of the scanner on a robot without one."""
        if "depth" in self.topics:
            seen = self.camera.scan(self.depth())
            nothing = seen.range >= 0.999 * FAR
            return seen._replace(range=np.where(nothing, np.nan, seen.range))
        around = self.around()
        here = np.abs(around.bearing) <= AHEAD
        return Scan(around.bearing[here], around.range[here], around.time)

    def around(self) -> Scan:
        """The scanner's view all around; on a robot without one, what stands ahead."""
        if "scan" not in self.topics:
            return self.ahead()
        turned = math.radians(self.profile.scan.turned)
        return self._decoded(lambda: laser(self._message("scan"), turned), "scan")

    def charge(self) -> float | None:
        """The battery's share of charge; None where it is not known."""
        heard = self._heard.get("battery")
        return contacts.charge(heard.message, self.profile.battery.type) if heard else None

    def docked(self) -> bool | None:
        """Whether the robot stands on its dock; None where nothing tells."""
        heard = self._heard.get("docked")
        return contacts.docked(heard.message, self.profile.docked.type) if heard else None

    def _message(self, key: str) -> Message:
        return self._heard[key].message

    def _decoded(self, decode, key: str):
        """What `decode` returns; its MessageFault names the topic."""
        try:
            return decode()
        except MessageFault as fault:
            topic = self.topics[key]
            raise MessageFault(f"{topic.name} ({topic.type}) sent {fault}") from fault


def full(namespace: str, name: str) -> str:
    """The full name of a topic or an action, in a namespace."""
    return f"/{namespace.strip('/')}/{name.lstrip('/')}" if namespace.strip("/") else name
