"""The docking server: drives home, approaches, recovers, and names what went wrong.

Phases: nav_to_staging -> acquire -> approach -> contact -> wait_for_charge -> docked, with recover
between attempts. One tick is a short motion (0.1 or 0.2 s) and gives feedback; a goal ends by its result, a cancel or
another goal, and in each case the wheels stand still.
"""

from __future__ import annotations

import math
from collections.abc import Generator

from curionav_cli.records import Pose
from curionav_cli.robot.docking.action import RECOVERABLE, Base, Code, Failed, Feedback, Goal, GoalState, Phase
from curionav_cli.robot.docking.approach import Approach, State
from curionav_cli.robot.docking.recoveries import steps
from curionav_cli.robot.docking_settings import Docking as Settings
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.navigation import TICKS, Navigator, Way

Ticks = Generator[None, None, None]
TICK = 0.1  # seconds of an approach's tick
SETTLE = 10  # ticks in which current may begin to flow after a contact
NEEDED = ("wheel", "gyro", "lidar", "depth", "infrared", "bumper")


class Docking:
    """state; code: how the last goal ended, None before; attempts, recoveries, seconds: of this goal."""

    def __init__(self, base: Base, localiser: Localiser, homing: Navigator, settings: Settings):
        self.base, self.localiser, self.homing, self.settings = base, localiser, homing, settings
        self.approach = Approach(settings.approach)
        self.state, self.phase = GoalState.pending, Phase.idle
        self.code: Code | None = None
        self.text, self.attempts, self.seconds = "", 0, 0.0
        self.recoveries: list[str] = []
        self._steps: Ticks = self._dock()

    # -- the action's verbs ---------------------------------------------------------------------------------------

    def request(self, goal: Goal) -> GoalState:
        """Take a goal; one that is active is preempted by it. A goal for another dock is rejected."""
        if goal.dock_id != "dock":
            return GoalState.rejected
        if self.state is GoalState.active:
            self._end(Code.preempted)
        self.goal, self.code, self.text = goal, None, ""
        self.attempts, self.recoveries, self.seconds = 0, [], 0.0
        self._silent = 0.0
        self._signals = (0, 0, 0)
        self.state, self._steps = GoalState.active, self._dock()
        return self.state

    def cancel(self) -> None:
        """Stop at once; the robot stands where it is, ready for another goal."""
        if self.state is GoalState.active:
            self.state = GoalState.preempting
            self._end(Code.cancelled)

    def tick(self) -> Feedback:
        """A little further. Nothing moves once there is a result."""
        if self.state is GoalState.active:
            try:
                self._listen()
            except StopIteration:
                self._end(Code.docked)
            except Failed as failure:
                self._end(failure.code, str(failure))
        here, dock = self.localiser.pose, self.goal.dock
        return Feedback(self.phase, self.approach.state.value, self.attempts, self.seconds, self._signals,
                        math.hypot(here.x - dock.x, here.y - dock.y))

    def _listen(self) -> None:
        """Stand still while a sensor is silent, else go on."""
        if self.base.silent.intersection(NEEDED):
            self.base.halt()
            self.base.drive(0.0, 0.0, TICK)
            self._count(TICK)
        else:
            next(self._steps)

    def _end(self, code: Code, text: str = "") -> None:
        self.base.halt()
        self._steps.close()
        self.code, self.text = code, text or code.text
        if code is Code.docked:
            self.state, self.phase = GoalState.succeeded, Phase.docked
        elif code in (Code.cancelled, Code.preempted):
            self.state, self.phase = GoalState.preempted, Phase.idle
        else:
            self.state, self.phase = GoalState.aborted, Phase.failed

    # -- how a goal is pursued: each `yield` is a tick ------------------------------------------------------------

    def _dock(self) -> Ticks:
        """Attempt after attempt, a recovery before each but the first; ends in silence or raises Failed."""
        todo = steps(self.settings)
        _, staging = next(todo)
        place = staging if self.goal.navigate else None
        while True:
            try:
                yield from self._attempt(place)
                return
            except Failed as failure:
                self.base.halt()
                following = next(todo, None)
                if failure.code not in RECOVERABLE or following is None:
                    raise
                self.recoveries.append(following[0])
                place = following[1]

    def _attempt(self, place: tuple[float, float] | None) -> Ticks:
        """To a place (metres before and to the left of the dock), and from there onto the dock."""
        if place:
            yield from self._drive_to(place)
        self.attempts += 1
        yield from self._approach()
        yield from self._charge()

    def _drive_to(self, place: tuple[float, float]) -> Ticks:
        self.phase = Phase.recover if self.recoveries else Phase.staging
        self.homing.set_out(before(self.goal.dock, *place))
        while True:
            way = self.homing.tick()
            if way is Way.arrived:
                return
            if way is not Way.going:
                raise Failed(Code.nav_timeout if way is Way.late else Code.nav_blocked)
            self._count(self.homing.seconds / TICKS)
            yield

    def _approach(self) -> Ticks:
        """The alignment drive until current flows. Limits: light, time, bumps."""
        settings, began, dark, bumps, turned = self.settings, self.seconds, 0.0, 0, 0.0
        self.phase, seen = Phase.acquire, False
        self.approach.restart()
        while True:
            self._signals = self.base.signals()
            dark = 0.0 if any(self._signals) else dark + TICK
            seen = seen or dark == 0.0
            if dark > (settings.approach.stuck if seen else settings.acquire):
                raise Failed(Code.dock_lost_in_approach if seen else Code.dock_not_seen)
            if self.seconds - began > settings.attempt:
                raise Failed(Code.approach_timeout, self.approach.state.value)
            speed, turn = self.approach.tick(self._signals, turned)
            turned, bump = self._move(speed, turn)
            yield
            self.phase = Phase.approach if seen else Phase.acquire
            if bump and self.approach.state is not State.bumped:
                if (yield from self._contact()):
                    return
                bumps += 1
                if bumps >= settings.bumps:
                    raise Failed(Code.no_charge_after_contact if self.approach.state is State.aligned_near
                                 else Code.bump_limit)
                self.approach.bump()

    def _contact(self) -> Generator[None, None, bool]:
        """Against something: does current flow?"""
        self.phase = Phase.contact
        for _ in range(SETTLE):
            self._move(0.0, 0.0)
            yield
            if self.base.charging:
                return True
        return False

    def _charge(self) -> Ticks:
        """Current must flow for some seconds."""
        self.phase, until = Phase.charge, self.seconds + self.settings.charge
        while self.seconds < until:
            if not self.base.charging:
                raise Failed(Code.charge_dropped)
            self._move(0.0, 0.0)
            yield

    def _move(self, speed: float, turn: float) -> tuple[float, bool]:
        """One tick of wheel speeds: (radians turned by the gyro, bumped)."""
        sensed = self.base.drive(speed * TICK, turn * TICK, TICK)
        self.localiser.update(sensed)
        self._count(TICK)
        return sensed.gyro if math.isfinite(sensed.gyro) else 0.0, sensed.bump is not None and speed > 0.0

    def _count(self, seconds: float) -> None:
        """Time passed: is there a reason to give up whatever is being done?"""
        self.seconds += seconds
        silent = sorted(self.base.silent.intersection(NEEDED))
        self._silent = self._silent + seconds if silent else 0.0
        if self.base.battery.empty:
            raise Failed(Code.battery_empty)
        if self.base.hazard:
            raise Failed(Code[self.base.hazard])
        if self._silent > self.settings.patience:
            raise Failed(Code.sensor_silent, ", ".join(silent))
        if self.seconds > self.settings.action:
            raise Failed(Code.deadline_passed)


def before(dock: Pose, ahead: float, aside: float) -> Pose:
    """The pose `ahead` metres before the dock and `aside` to its left, looking at it."""
    cosine, sine = math.cos(dock.yaw), math.sin(dock.yaw)
    x, y = dock.x + ahead * cosine - aside * sine, dock.y + ahead * sine + aside * cosine
    return Pose(x, y, math.atan2(dock.y - y, dock.x - x))
