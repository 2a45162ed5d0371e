"""Goals of a served robot: the base's own actions, each a generator that yields after a short motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from curionav_cli.live.served.body import TICK, ServedBody
from curionav_cli.live.transport import ENDED, Message
from curionav_cli.robot.docking.action import Code, GoalState
from curionav_cli.robot.docking.action import Goal as DockGoal
from curionav_cli.robot.docking.server import DockingServer
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.navigation import Navigator
from curionav_cli.robot.occupancy import Occupancy

SPEED, RATE_OF_TURN = 0.3, 0.8  # m/s and rad/s of the base's own moves at most
BACK, BACK_SPEED = 0.4, 0.15  # metres and m/s back from the dock, before it turns round


class Aborted(Exception):
    """A goal that the base cannot reach; the message says why."""


class ServedGoal:
    """A goal that was accepted (transport.Work). `advance` carries it out, `cancel` may come from another thread."""

    def __init__(self, motion: Iterator[None], result: Callable[[], Message]):
        self._motion, self._result = motion, result
        self.state, self.text = GoalState.active, ""

    @property
    def result(self) -> Message:
        return self._result()

    def cancel(self) -> None:
        if self.state is GoalState.active:
            self.state = GoalState.preempting

    def advance(self) -> bool:
        """Make a short motion; returns whether the goal goes on."""
        if self.state is GoalState.preempting:
            self.state = GoalState.preempted
            self._motion.close()  # type: ignore[attr-defined]
        else:
            self._continue()
        return self.state not in ENDED  # a cancel may have come during the motion

    def _continue(self) -> None:
        try:
            next(self._motion)
        except StopIteration:
            self.state = GoalState.succeeded
        except Aborted as why:
            self.state, self.text = GoalState.aborted, str(why)


def drive(body: ServedBody, goal: Message) -> Iterator[None]:
    """irobot_create_msgs/DriveDistance: straight ahead, or back; something that is touched aborts it."""
    distance = float(goal["distance"])
    most = float(goal.get("max_translation_speed") or SPEED)
    yield from straight(body, distance, min(most, SPEED))


def straight(body: ServedBody, distance: float, speed: float) -> Iterator[None]:
    """Drive `distance` metres at `speed` m/s."""
    for part in parts(distance, speed):
        if body.tick(part, 0.0).bump:
            raise Aborted("the bumper was pressed")
        yield


def turn(body: ServedBody, goal: Message) -> Iterator[None]:
    """irobot_create_msgs/RotateAngle: on the spot, to the left."""
    most = float(goal.get("max_rotation_speed") or RATE_OF_TURN)
    for part in parts(float(goal["angle"]), min(most, RATE_OF_TURN)):
        body.tick(0.0, part)
        yield


def undock(body: ServedBody, goal: Message) -> Iterator[None]:
    """irobot_create_msgs/Undock: back from the dock, and round."""
    if not body.charging:
        raise Aborted("it is not docked")
    yield from straight(body, -BACK, BACK_SPEED)
    yield from turn(body, {"angle": math.pi})


def dock(body: ServedBody, goal: Message) -> Iterator[None]:
    """The base's docking by the dock's infrared light, from where it stands: one attempt, as the maker's."""
    if body.charging:
        return
    settings = replace(body.profile.docking, recoveries=[])
    localiser = Localiser(body.profile, body.body.pose)
    navigator = Navigator(body, localiser, Occupancy(), body.station.radius, body.profile.step)
    server = DockingServer(body, localiser, navigator, settings)
    server.request(DockGoal(body.station.dock, navigate=False))
    try:
        while server.code is None:
            server.tick()
            yield
    finally:
        server.cancel()
    if server.code is not Code.docked:
        raise Aborted(f"{server.code.name}: {server.text}")


def parts(whole: float, speed: float) -> Iterator[float]:
    """`whole` metres or radians cut into what is driven in a tick at `speed` a second, the last part smaller."""
    step = abs(speed) * TICK
    full = int(abs(whole) / step + 1e-9)
    rest = abs(whole) - full * step
    for part in [step] * full + [rest] * (rest > 1e-12):
        yield math.copysign(part, whole)


MOTIONS: dict[str, Callable[[ServedBody, Message], Iterator[None]]] = {
    "drive": drive, "turn": turn, "dock": dock, "undock": undock}
