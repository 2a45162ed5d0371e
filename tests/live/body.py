"""A simulated robot behind topics and actions in memory, and a clock that only it moves."""

from __future__ import annotations

import base64
import math
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np

from curionav_cli.geometry import wrapped
from curionav_cli.live.memory import Memory
from curionav_cli.live.sensors import full
from curionav_cli.live.settings import Rosbridge
from curionav_cli.robot.docking.action import GoalState

TICK = 0.02
EVERY = {"odom": 2, "imu": 2, "image": 5, "depth": 5, "scan": 5, "battery": 25, "docked": 10}  # ticks
RADIUS, LONG, WIDE = 0.18, 6.0, 4.0  # metres: the robot and its room
DOCK = (1.0, 2.0, 0.0)  # the docked robot's centre, and the way out of it
ORIGIN = (0.7, -0.3, 0.4)  # of odometry's frame


@dataclass
class Goal:
    """A goal that the body carries out over time."""

    kind: str
    goal: dict[str, Any]
    state: GoalState = GoalState.active
    text: str = ""
    left: float = 0.0

    def cancel(self) -> None:
        self.state = GoalState.preempted


@dataclass
class Body:
    """The robot. silent: topics that send nothing; outcome: how actions end by kind, where not in success."""

    settings: Rosbridge
    told: bool = True
    encoding: str = "rgb8"
    depth_encoding: str = "32FC1"
    stiff: bool = False  # the wheels do not turn
    silent: set[str] = field(default_factory=set)
    outcome: dict[str, GoalState] = field(default_factory=dict)
    charge: float = 0.9
    obstacle: float = math.inf  # x of a wall that the sensors do not see
    clock_offset: float = 1000.0  # the robot's clock is not ours

    def __post_init__(self) -> None:
        profile = self.settings.profile
        self.time, self.ticks, self.speed, self.rate = 0.0, 0, 0.0, 0.0
        self.docked = bool(profile.dock.name)
        self.x, self.y, self.yaw = DOCK[0], DOCK[1], math.pi if self.docked else 0.0
        self.goals: list[Goal] = []
        self.watch: list[Any] = []  # called at each tick
        name = self.settings.namespace
        offered = {full(name, topic.name): topic.type for topic in profile.topics().values()}
        offered[full(name, profile.velocity.name)] = profile.velocity.type
        servers = {full(name, action.name): self._server(kind) for kind, action in profile.actions().items()}
        self.link = Memory(offered, servers, self.told)
        self.link.listeners[full(name, profile.velocity.name)] = self._command

    # -- the clock ------------------------------------------------------------------------------------------------

    def now(self) -> float:
        return self.time

    def sleep(self, seconds: float) -> None:
        for _ in range(max(1, round(seconds / TICK))):
            self.tick()

    # -- motion ---------------------------------------------------------------------------------------------------

    def _command(self, message: dict[str, Any]) -> None:
        plain = message.get("twist", message)
        self.speed, self.rate = plain["linear"]["x"], plain["angular"]["z"]

    def _server(self, kind: str):
        def server(goal: dict[str, Any]) -> Goal:
            sent = Goal(kind, goal)
            sent.left = abs({"drive": goal.get("distance"), "turn": goal.get("angle"), "dock": 1.0,
                             "undock": math.pi}[kind])
            self.goals.append(sent)
            return sent
        return server

    def tick(self) -> None:
        self.time += TICK
        self.ticks += 1
        active = [goal for goal in self.goals if goal.state is GoalState.active]
        speed, rate = (self.speed, self.rate) if not active else self._carry_out(active[-1])
        if active and active[-1].state is not GoalState.active:
            speed, rate = 0.0, 0.0
        self.yaw = wrapped(self.yaw + rate * TICK)
        self._drive(speed * TICK)
        self.now_speed, self.now_rate = speed, rate
        if math.hypot(self.x - DOCK[0], self.y - DOCK[1]) > 0.05:
            self.docked = False
        for key in self.settings.profile.topics():
            if self.ticks % EVERY.get(key, 10**9) == 0 and key not in self.silent:
                self.publish(key)
        for callback in self.watch:
            callback()

    def _carry_out(self, goal: Goal) -> tuple[float, float]:
        if goal.kind in self.outcome:
            goal.state = self.outcome[goal.kind]
            return 0.0, 0.0
        if goal.kind == "dock":
            return self._dock(goal)
        step = {"drive": 0.25, "turn": 0.8, "undock": 1.0}[goal.kind] * TICK
        done = min(step, goal.left)
        goal.left -= done
        if goal.left <= 1e-9:
            goal.state = GoalState.succeeded
        if goal.kind == "drive":
            self._drive(math.copysign(done, goal.goal["distance"]))
        elif goal.kind == "turn":
            self.yaw = wrapped(self.yaw + math.copysign(done, goal.goal["angle"]))
        else:
            self.docked = False
            self._drive(-0.4 * done / math.pi if goal.left > 0 else 0.0)
            if goal.state is GoalState.succeeded:
                goal.left, goal.state, goal.kind, goal.goal = math.pi, GoalState.active, "turn", {"angle": math.pi}
        return 0.0, 0.0

    def _dock(self, goal: Goal) -> tuple[float, float]:
        """From before the dock, and facing it, drive onto it; elsewhere the action is aborted."""
        ahead, aside = self.x - DOCK[0], self.y - DOCK[1]
        facing = abs(wrapped(self.yaw - math.pi))
        if goal.left == 1.0 and (ahead > 1.5 or abs(aside) > 0.5 or facing > 0.7):
            goal.state = GoalState.aborted
            return 0.0, 0.0
        goal.left -= TICK / 2.0
        share = min(1.0, TICK / 2.0 / max(goal.left + TICK / 2.0, 1e-9))
        self.x, self.y = self.x - share * ahead, self.y - share * aside
        self.yaw = wrapped(self.yaw - share * wrapped(self.yaw - math.pi))
        if goal.left <= 1e-9:
            goal.state, self.docked = GoalState.succeeded, True
        return 0.0, 0.0

    def _drive(self, metres: float) -> None:
        if self.stiff or not metres:
            return
        x, y = self.x + metres * math.cos(self.yaw), self.y + metres * math.sin(self.yaw)
        most = min(LONG, self.obstacle) - RADIUS
        if RADIUS <= x <= most and RADIUS <= y <= WIDE - RADIUS:
            self.x, self.y = x, y
        elif "touch" not in self.silent:
            self.touch(True)
            return
        self.touch(False)

    def touch(self, pressed: bool) -> None:
        """Report the bumper as this profile's maker does."""
        if getattr(self, "_pressed", False) == pressed:
            return
        self._pressed = pressed
        for name, kind in self.settings.profile.contacts.items():
            kinds = {"BumperEvent": {"bumper": 1, "state": int(pressed)}, "SensorState": {"bumper": int(pressed)},
                     "HazardDetectionVector": {"detections": [{"type": 1}] * pressed}}
            if message := kinds.get(kind.rpartition("/")[2]):
                self.link.send(full(self.settings.namespace, name), message)

    def lift(self, up: bool) -> None:
        """Report that a wheel hangs, or stands again, as this profile's maker does."""
        for name, kind in self.settings.profile.contacts.items():
            kinds = {"WheelDropEvent": {"wheel": 0, "state": int(up)},
                     "HazardDetectionVector": {"detections": [{"type": 4}] * up}}
            if message := kinds.get(kind.rpartition("/")[2]):
                self.link.send(full(self.settings.namespace, name), message)

    # -- what it sends --------------------------------------------------------------------------------------------

    def header(self, ago: float = 0.0) -> dict[str, Any]:
        seconds = self.time + self.clock_offset - ago
        whole, part = int(seconds), round(1e9 * (seconds % 1.0))
        two = {"sec": whole, "nanosec": part}
        return {"stamp": two if self.settings.profile.ros == 2 else {"secs": whole, "nsecs": part}}

    def publish(self, key: str, ago: float = 0.0) -> None:
        """Send a message of a topic now; ago: seconds by which its stamp lies back."""
        topic = self.settings.profile.topics()[key]
        message = getattr(self, f"_{key}")(topic.type)
        if message is not None:
            self.link.send(full(self.settings.namespace, topic.name), {"header": self.header(ago), **message})

    def _odom(self, kind: str) -> dict[str, Any]:
        dx, dy = self.x - ORIGIN[0], self.y - ORIGIN[1]
        x = math.cos(ORIGIN[2]) * dx + math.sin(ORIGIN[2]) * dy
        y = math.cos(ORIGIN[2]) * dy - math.sin(ORIGIN[2]) * dx
        half = 0.5 * (self.yaw - ORIGIN[2])
        turn = {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)}
        return {"pose": {"pose": {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turn}},
                "twist": {"twist": {"linear": {"x": self.now_speed}, "angular": {"z": self.now_rate}}}}

    @property
    def dark(self) -> bool:
        """Whether the camera is off, as that of a docked TurtleBot 4 is."""
        return self.docked and bool(self.settings.profile.undock.name)

    def _imu(self, kind: str) -> dict[str, Any]:
        before, self._last_yaw = getattr(self, "_last_yaw", self.yaw), self.yaw
        return {"angular_velocity": {"x": 0.0, "y": 0.0, "z": wrapped(self.yaw - before) / (EVERY["imu"] * TICK)}}

    @property
    def colour(self) -> tuple[int, int, int]:
        """What the camera sees: a colour for each place."""
        return round(40 * self.x) % 256, round(40 * self.y) % 256, round(40 * (self.yaw + math.pi)) % 256

    def _image(self, kind: str) -> dict[str, Any] | None:
        if self.dark:
            return None
        pixels = np.full((48, 80, 3), self.colour, np.uint8)
        if kind.endswith("CompressedImage"):
            raw = cv2.imencode(".png", pixels[:, :, ::-1])[1].tobytes()
            return {"format": "png", "data": base64.b64encode(raw).decode()}
        if self.encoding == "bgr8":
            pixels = pixels[:, :, ::-1]
        return {"encoding": self.encoding, "height": 48, "width": 80, "step": 240, "is_bigendian": 0,
                "data": base64.b64encode(pixels.tobytes()).decode()}

    def _ranges(self, bearing: np.ndarray) -> np.ndarray:
        """Ranges (A,) to the walls of the room."""
        cosine, sine = np.cos(self.yaw + bearing), np.sin(self.yaw + bearing)
        with np.errstate(divide="ignore"):
            x = np.where(cosine > 0, (LONG - self.x) / cosine, -self.x / cosine)
            y = np.where(sine > 0, (WIDE - self.y) / sine, -self.y / sine)
        return np.minimum(np.abs(x), np.abs(y))

    def _depth(self, kind: str) -> dict[str, Any] | None:
        if self.dark:
            return None
        across = math.tan(math.radians(30.0)) * ((np.arange(64) + 0.5) / 32 - 1.0)
        ahead = self._ranges(-np.arctan(across)) / np.sqrt(1.0 + across**2)
        metres = np.broadcast_to(ahead, (64, 64)).astype(np.float32)
        raw = metres if self.depth_encoding == "32FC1" else np.round(1000 * metres).astype("<u2")
        return {"encoding": self.depth_encoding, "height": 64, "width": 64, "step": raw.itemsize * 64,
                "is_bigendian": 0, "data": base64.b64encode(np.ascontiguousarray(raw).tobytes()).decode()}

    def _scan(self, kind: str) -> dict[str, Any] | None:
        if self.dark:
            return None
        turned = math.radians(self.settings.profile.scan.turned)
        bearing = np.linspace(-math.pi, math.pi, 72, endpoint=False)
        return {"angle_min": -math.pi - turned, "angle_increment": 2.0 * math.pi / 72, "range_min": 0.1,
                "range_max": 12.0, "ranges": self._ranges(bearing).tolist()}

    def _battery(self, kind: str) -> dict[str, Any]:
        return self._state() if kind.endswith("/SensorState") else {"percentage": self.charge}

    def _docked(self, kind: str) -> dict[str, Any]:
        return self._state() if kind.endswith("/SensorState") else {"is_docked": self.docked}

    def _state(self) -> dict[str, Any]:
        return {"battery": round(10 * (13.2 + 3.3 * self.charge)), "charger": 6 if self.docked else 0}
