"""Moves of a real robot: by velocity commands closed on odometry, or by actions of its base."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from curionav_cli.constants import STEP_LENGTH
from curionav_cli.live.clock import Clock
from curionav_cli.live.messages import twist
from curionav_cli.live.safety import Fault
from curionav_cli.live.sensors import Sensors, full
from curionav_cli.live.settings import Rosbridge, Topic, Twist
from curionav_cli.live.transport import ENDED, Goal, Transport
from curionav_cli.robot.docking.action import GoalState

PERIOD = 0.05  # seconds between two commands; the bases stop by themselves after 0.5 s without one
SLOW, SLOW_TURN = 0.04, math.radians(8.0)  # m/s and rad/s towards the end of a move
GAIN = 2.0  # 1/s: speed for what is left of a move
NEAR, NEAR_TURN = 0.005, math.radians(0.3)  # metres and radians that may be left
SHORT, SHORT_TURN = 0.05, math.radians(3.0)  # metres and radians; a move that ends farther off was cut short
STILL, STILL_TURN, SETTLING = 0.02, 0.05, 0.6  # m/s, rad/s, and seconds to wait for it
QUARTER = math.pi / 4.0  # radians; longer turns have more time
STOPS = ("bumper", "cliff", "wheel_drop", "stall")

Pause = Callable[[], None]


class Wheels:
    """The velocity topic, and the goal that runs now. pause: lets a moment pass and raises Fault where we must stop."""

    def __init__(self, transport: Transport, sensors: Sensors, settings: Rosbridge, clock: Clock):
        self.transport, self.sensors, self.settings, self.clock = transport, sensors, settings, clock
        self.velocity = (0.0, 0.0)
        self.goal: Goal | None = None
        self._acting, self.answer = "", ""  # the action of the goal; what the base said at the last one's end
        topic = settings.profile.velocity
        self.topic = full(settings.namespace, topic.name)
        self.stamped = stamped(settings, transport, self.topic)
        transport.advertise(self.topic, velocity_type(topic, self.stamped, settings.profile.ros))

    def send(self, speed: float, rate: float) -> None:
        """Command a speed (m/s) and a rate (rad/s to the left), within the limits that were set."""
        most, turn = self.settings.max_speed, math.radians(self.settings.max_turn)
        self.velocity = (max(-most, min(most, speed)), max(-turn, min(turn, rate)))
        now = self.sensors.travel.now
        message = twist(*self.velocity, self.stamped, now.stamp if now else 0.0, self.settings.profile.ros)
        self.transport.publish(self.topic, message)

    def check(self) -> None:
        """Raise Fault where commands or the goal do not arrive, as with a type that the robot does not listen to."""
        names = [self.topic, self._acting] if self.goal is not None else [self.topic]
        for name, said in zip(names, map(self.transport.complaint, names)):
            if said:
                raise Fault(f"{name} does not reach the robot; the server says: {said}")

    def halt(self) -> None:
        """Stop the wheels and cancel what the base is doing."""
        if self.goal is not None and self.goal.state not in ENDED:
            self.goal.cancel()
        self.goal = None
        self.send(0.0, 0.0)

    def act(self, action: Topic, goal: dict[str, object], seconds: float, pause: Pause,
            stopped: Callable[[], bool] = lambda: False) -> GoalState:
        """Have the base carry out an action; it is cancelled after `seconds`, where `stopped()`, and by a Fault."""
        until, self._acting = self.clock.now() + seconds, full(self.settings.namespace, action.name)
        sent = self.goal = self.transport.action(self._acting, action.type, goal)
        try:
            while sent.state not in ENDED:
                if self.clock.now() > until or stopped():
                    return self._cancelled(sent, pause)
                pause()
        except BaseException:
            self.halt()
            raise
        self.goal, self.answer = None, f" ({sent.text})" if sent.text.strip("{}") else ""
        return sent.state

    def _cancelled(self, sent: Goal, pause: Pause) -> GoalState:
        """Cancel a goal and wait a moment for the base to say so."""
        sent.cancel()
        until = self.clock.now() + 1.0
        while sent.state not in ENDED and self.clock.now() < until:
            pause()
        self.goal = None
        return GoalState.preempted


class Mover(Protocol):
    """Makes the two kinds of move; each returns whether it was cut short."""

    def forward(self, metres: float, pause: Pause) -> bool:
        """Drive straight on, or back where `metres` is negative."""

    def turn(self, radians: float, pause: Pause) -> bool:
        """Turn on the spot, to the left."""


class ByVelocity:
    """Moves by velocity commands, which odometry ends."""

    def __init__(self, wheels: Wheels):
        self.wheels, self.clock, self.travel = wheels, wheels.clock, wheels.sensors.travel

    def forward(self, metres: float, pause: Pause) -> bool:
        start, seconds = self.travel.forward, limit(self.wheels.settings, metres / STEP_LENGTH)
        left = self._drive(lambda: metres - (self.travel.forward - start), NEAR, seconds,
                           lambda rest: (eased(rest, SLOW, self.wheels.settings.max_speed), 0.0),
                           touched if metres > 0.0 else lifted, pause)
        return abs(left) > SHORT

    def turn(self, radians: float, pause: Pause) -> bool:
        start, most = self.travel.turned, math.radians(self.wheels.settings.max_turn)
        left = self._drive(lambda: radians - (self.travel.turned - start), NEAR_TURN,
                           limit(self.wheels.settings, radians / QUARTER),
                           lambda rest: (0.0, eased(rest, SLOW_TURN, most)), lifted, pause)
        return abs(left) > SHORT_TURN

    def _drive(self, left: Callable[[], float], near: float, seconds: float,
               command: Callable[[float], tuple[float, float]], stops: Callable[[Sensors], bool], pause: Pause
               ) -> float:
        """Command until no more than `near` is left, `seconds` are over or `stops` is true; returns what is left."""
        sign, until = math.copysign(1.0, left()), self.clock.now() + seconds
        try:
            while sign * left() > near and self.clock.now() < until and not stops(self.wheels.sensors):
                self.wheels.send(*command(left()))
                pause()
        finally:
            self.wheels.halt()
        self._settle(pause)
        return left()

    def _settle(self, pause: Pause) -> None:
        until = self.clock.now() + SETTLING
        pause()
        while self.clock.now() < until and moving(self.wheels.sensors):
            pause()


class ByActions:
    """Moves by the base's own actions (Create 3), closed on the robot; no velocity command goes over the air."""

    def __init__(self, wheels: Wheels):
        self.wheels, self.travel, self.profile = wheels, wheels.sensors.travel, wheels.settings.profile

    def forward(self, metres: float, pause: Pause) -> bool:
        start = self.travel.forward
        goal: dict[str, object] = {"distance": metres, "max_translation_speed": self.wheels.settings.max_speed}
        stops = touched if metres > 0.0 else lifted
        self.wheels.act(self.profile.drive, goal, limit(self.wheels.settings, metres / STEP_LENGTH), pause,
                        lambda: stops(self.wheels.sensors))
        pause()
        return abs(metres - (self.travel.forward - start)) > SHORT

    def turn(self, radians: float, pause: Pause) -> bool:
        most = math.radians(self.wheels.settings.max_turn)
        state = self.wheels.act(self.profile.turn, {"angle": radians, "max_rotation_speed": most},
                                limit(self.wheels.settings, radians / QUARTER), pause,
                                lambda: lifted(self.wheels.sensors))
        pause()
        return state is not GoalState.succeeded


def limit(settings: Rosbridge, actions: float) -> float:
    """Seconds that a move of so many actions may take."""
    return settings.move * max(1.0, abs(actions))


def mover(wheels: Wheels) -> Mover:
    """The way in which the robot of these wheels moves."""
    return ByActions(wheels) if wheels.settings.profile.by_actions else ByVelocity(wheels)


def eased(left: float, slowest: float, fastest: float) -> float:
    """The speed for what is left of a move: proportional, within bounds, with its sign."""
    return math.copysign(max(slowest, min(fastest, GAIN * abs(left))), left)


def touched(sensors: Sensors) -> bool:
    """Whether a bumper is pressed, a wheel hangs, or the floor ends: no move ahead goes on."""
    return any(name.startswith(STOPS) for name, now in sensors.touching.items() if now)


def lifted(sensors: Sensors) -> bool:
    """Whether a wheel hangs: no move goes on. Turning and backing off is how a robot leaves a wall or an edge."""
    return any(name.startswith("wheel_drop") for name, now in sensors.touching.items() if now)


def moving(sensors: Sensors) -> bool:
    """Whether odometry says that the robot moves."""
    now = sensors.travel.now
    return now is not None and (abs(now.speed) > STILL or abs(now.rate) > STILL_TURN)


def stamped(settings: Rosbridge, transport: Transport, topic: str) -> bool:
    """Whether velocity commands have a header. Raises Fault where auto cannot know."""
    if settings.twist is not Twist.auto:
        return settings.twist is Twist.stamped
    kind = transport.topics().get(topic, settings.profile.velocity.type)
    if not kind.endswith(("/Twist", "/TwistStamped")):
        raise Fault(f"{topic} is of type {kind}, and velocity commands are Twist or TwistStamped")
    return kind.endswith("/TwistStamped")


def velocity_type(topic: Topic, stamped: bool, ros: int) -> str:
    """The type of velocity commands, in the spelling of this ROS."""
    return f"geometry_msgs/{'msg/' * (ros == 2)}Twist{'Stamped' * stamped}"
