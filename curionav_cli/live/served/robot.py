"""A served robot: the simulated body behind the topics and actions that a profile names, over any transport."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from curionav_cli.errors import ConfigError
from curionav_cli.live.messages import command
from curionav_cli.live.safety import MessageFault
from curionav_cli.live.sensors import SILENT_ON_DOCK, full
from curionav_cli.live.served.body import RATE, TICK, ServedBody
from curionav_cli.live.served.goals import MOTIONS, ServedGoal
from curionav_cli.live.served.reports import Moment, Writer, writer
from curionav_cli.live.served.settings import Serving
from curionav_cli.live.settings import Rosbridge, Topic
from curionav_cli.live.transport import Message, Transport
from curionav_cli.live.wheels import stamped, velocity_type
from curionav_cli.world.render.renderer import Renderer

SENT = {"odom": 25.0, "imu": 25.0, "scan": 10.0, "battery": 2.0, "docked": 5.0, "dock_ir": 10.0, "contact": 5.0,
        "truth": 25.0, "frames": 25.0, "clock": 25.0}  # times a second
EVENTS = ("BumperEvent", "CliffEvent", "WheelDropEvent")  # sent where something changes only
FASTEST, FASTEST_TURN = 0.7, 3.1  # m/s and rad/s that the wheels can do
HAND = "/put_back"  # a person's hand: carries the robot back to where it began
DEAF_AFTER = 0.5  # seconds without a command after which the wheels stop


class Sent(NamedTuple):
    """A topic that is sent. every: ticks between two messages; 0: only where something was touched or let go."""

    key: str
    name: str
    write: Writer
    every: int


class ServedRobot:
    """A robot of `link.profile` in `link.namespace`. epoch: seconds that stamps add to its own time. say: prints.

    It moves only in `step`, in one thread; commands and goals may come from others. Without a dock action in its
    profile there is no dock, and it starts at the scene's start.
    """

    def __init__(self, body: ServedBody, renderer: Renderer, link: Rosbridge, serving: Serving, transport: Transport,
                 epoch: float = 0.0, say: Callable[[str], None] = print):
        self.body, self.renderer, self.link, self.serving = body, renderer, link, serving
        self.transport, self.epoch, self.say = transport, epoch, say
        self.goal: ServedGoal | None = None
        self._waiting: list[ServedGoal] = []
        self._command, self._commanded = (0.0, 0.0), -DEAF_AFTER
        self._pressed: str | None = None
        self._complained, self._carried = "", False
        self._lock = threading.Lock()
        self.sent = [self._advertised(key, topic) for key, topic in topics_of(link, serving).items()]
        self._listen()
        body.after = self._report

    def _advertised(self, key: str, topic: Topic) -> Sent:
        name, event = full(self.link.namespace, topic.name), topic.type.endswith(EVENTS)
        self.transport.advertise(name, topic.type)
        rate = self.serving.images if key in ("image", "depth") else SENT[key.partition(" ")[0]]
        return Sent(key, name, writer(key, topic.type), 0 if event else max(1, round(RATE / rate)))

    def _listen(self) -> None:
        profile, name = self.link.profile, full(self.link.namespace, self.link.profile.velocity.name)
        kind = velocity_type(profile.velocity, stamped(self.link, self.transport, name), profile.ros)
        self.commands = f"{name} ({kind})"
        self.transport.subscribe(name, kind, self._take_command)
        self.transport.subscribe(full(self.link.namespace, HAND), f"std_msgs/{'msg/' * (profile.ros == 2)}Empty",
                                 self._take_hand)
        for key, action in profile.actions().items():
            take = partial(self._take_goal, key, action.type)
            self.transport.offer(full(self.link.namespace, action.name), action.type, take)

    def names(self) -> list[str]:
        """The full names of its topics and actions."""
        actions = [full(self.link.namespace, action.name) for action in self.link.profile.actions().values()]
        return [*(sent.name for sent in self.sent), self.commands.partition(" ")[0], *actions]

    # -- what comes in, in any thread -----------------------------------------------------------------------------

    def _take_command(self, message: Message) -> None:
        try:
            speed, rate = command(message)
        except MessageFault as fault:
            if str(fault) != self._complained:
                self._complained = str(fault)
                self.say(f"{self.link.profile.velocity.name}: {fault}")
            return
        with self._lock:
            self._command = (max(-FASTEST, min(FASTEST, speed)), max(-FASTEST_TURN, min(FASTEST_TURN, rate)))
            self._commanded = self.body.time

    def _take_hand(self, message: Message) -> None:
        self._carried = True

    def _take_goal(self, key: str, kind: str, message: Message) -> ServedGoal:
        goal = ServedGoal(MOTIONS[key](self.body, message), partial(self._result, kind))
        with self._lock:
            self._waiting.append(goal)
        return goal

    def _result(self, kind: str) -> Message:
        """What a Create 3 answers to Dock and Undock; the fields of other results stay at their defaults."""
        return {"is_docked": self.body.charging} if kind.endswith(("/Dock", "/Undock")) else {}

    # -- motion ---------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Simulated seconds."""
        return self.body.time

    def step(self) -> None:
        """Go on by a short motion: of the goal, or of a tick by the last command."""
        if self._carried:
            self._carried = False
            self.body.put_back()
        self._next_goal()
        with self._lock:
            speed, rate = self._command
            deaf = self.body.time >= self._commanded + DEAF_AFTER
        if self.goal is None:
            self.body.tick(*(0.0, 0.0) if deaf else (speed * TICK, rate * TICK))
        elif not self.goal.advance():
            self.goal = None

    def _next_goal(self) -> None:
        """Begin the newest goal; the one before is given up."""
        with self._lock:
            waiting, self._waiting = self._waiting, []
        for goal in waiting:
            if self.goal is not None:
                self.goal.cancel()
                self.goal.advance()
            self.goal = goal

    def run(self, seconds: float) -> None:
        """Let time pass."""
        until = self.body.time + seconds - 0.5 * TICK
        while self.body.time < until:
            self.step()

    # -- what is sent ---------------------------------------------------------------------------------------------

    def _report(self) -> None:
        """Send what is due after a tick."""
        bump = self.body.reading.bump
        changed = [side for side in (self._pressed, bump) if side and self._pressed != bump]
        self._pressed = bump
        dark = self.body.charging and bool(self.link.profile.undock.name)
        now = self.moment()
        for key, name, write, every in self.sent:
            if every and self.body.ticks % every == 0 and not (dark and key in SILENT_ON_DOCK):
                self.transport.publish(name, write(now))
            for side in changed if key.startswith("contact") else ():
                self.transport.publish(name, write(now._replace(side=side)))

    def moment(self) -> Moment:
        """The present, whose picture is rendered once at most."""
        pictures: list[tuple[np.ndarray, np.ndarray]] = []

        def views() -> tuple[np.ndarray, np.ndarray]:
            if not pictures:
                image, depth = self.renderer.look(*self.body.body.pose)
                pictures.append((image[0], depth[0]))
            return pictures[0]
        return Moment(self.body, self.epoch + self.body.time, self.link.profile.ros, views,
                      np.radians(self.link.profile.scan.turned))


def topics_of(link: Rosbridge, serving: Serving) -> dict[str, Topic]:
    """Everything that is sent, each topic once: those of the profile, the true pose, frames and clock.

    Raises ConfigError for images of which the profile uses a part, and for a type that is not known.
    """
    profile, kind = link.profile, "msg/" * (link.profile.ros == 2)
    if min(profile.image.crop, profile.depth.crop) < 1.0:
        raise ConfigError("robot.profile.image.crop, depth.crop: served images are square and used whole. Set 1.")
    more = {"truth": Topic("/ground_truth", f"nav_msgs/{kind}Odometry"),
            "frames": Topic("/tf", f"tf2_msgs/{kind}TFMessage")}
    if serving.speed != 1.0:
        more["clock"] = Topic("/clock", f"rosgraph_msgs/{kind}Clock")
    found = {**profile.topics(), **more}
    for key, topic in found.items():
        writer(key, topic.type)
    names = [topic.name for topic in found.values()]
    return {key: topic for at, (key, topic) in enumerate(found.items()) if topic.name not in names[:at]}
