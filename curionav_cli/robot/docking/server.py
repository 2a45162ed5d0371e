"""The docking server: navigate to the staging pose, approach, wait for charge; recover after a failed attempt.

Phases: nav_to_staging -> acquire -> approach -> contact -> wait_for_charge -> docked, with recover
between attempts. One tick is a short motion (0.1 or 0.2 s) and gives feedback; a goal ends with a result, a cancel or
another goal, and the wheels stand still in each case.

What happens when docking fails (`_dock_robot`): a phase raises AttemptFailed (staging pose not reached, no infrared
light, light lost, approach too long, too many bumps, no current), and the next attempt begins from the place of the
next recovery: the profile lists them in docking.recoveries (recoveries.py). The goal is aborted with a Code where none
is left, or at once by DockingAborted (empty battery, silent sensor, hazard, deadline). Then RobotEnv.reset (env.py)
puts the robot onto the dock, as a person would, and the report says human=True.
"""

from __future__ import annotations

import math
from collections.abc import Generator

from curionav_cli.records import Pose
from curionav_cli.robot.docking.action import (
    AttemptFailed,
    Code,
    DockingAborted,
    DockingFailed,
    FailedToCharge,
    FailedToControl,
    FailedToDetectDock,
    FailedToStage,
    Feedback,
    Goal,
    GoalState,
    Phase,
)
from curionav_cli.robot.docking.approach import Approach, State
from curionav_cli.robot.docking.recoveries import attempts
from curionav_cli.robot.docking_settings import ByLight
from curionav_cli.robot.interface import Docker, Estimate
from curionav_cli.robot.navigation import TICKS, Navigator, NavStatus

Ticks = Generator[None, None, None]
TICK = 0.1  # seconds of an approach's tick
SETTLE = 10  # ticks in which current may begin to flow after a contact
NEEDED = ("wheel", "gyro", "lidar", "depth", "infrared", "bumper")


class DockingServer:
    """The server. code: how the last goal ended, None before; attempts, recoveries, seconds: of the present goal."""

    def __init__(self, base: Docker, localiser: Estimate, navigator: Navigator, settings: ByLight):
        self.base, self.localiser, self.navigator, self.settings = base, localiser, navigator, settings
        self.approach = Approach(settings.approach)
        self.state, self.phase = GoalState.pending, Phase.idle
        self.code: Code | None = None
        self.text, self.attempts, self.seconds = "", 0, 0.0
        self.recoveries: list[str] = []
        self._progress: Ticks = self._dock_robot()

    # -- the action's verbs ---------------------------------------------------------------------------------------

    def request(self, goal: Goal) -> GoalState:
        """Accept a goal, preempting the active one. A goal for another dock is rejected."""
        if goal.dock_id != "dock":
            return GoalState.rejected
        if self.state is GoalState.active:
            self._end(Code.preempted)
        self.goal, self.code, self.text = goal, None, ""
        self.attempts, self.recoveries, self.seconds = 0, [], 0.0
        self._silent = 0.0
        self._signals = (0, 0, 0)
        self.state, self._progress = GoalState.active, self._dock_robot()
        return self.state

    def cancel(self) -> None:
        """Stop at once; the robot stays where it is, ready for another goal."""
        if self.state is GoalState.active:
            self.state = GoalState.preempting
            self._end(Code.cancelled)

    def tick(self) -> Feedback:
        """Run one short motion and return the feedback. Nothing moves once there is a result."""
        if self.state is GoalState.active:
            try:
                self._advance()
            except StopIteration:
                self._end(Code.docked)
            except DockingFailed as failure:
                self._end(failure.code, str(failure))
        here, dock = self.localiser.pose, self.goal.dock
        return Feedback(self.phase, self.approach.state.value, self.attempts, self.seconds, self._signals,
                        math.hypot(here.x - dock.x, here.y - dock.y))

    def _advance(self) -> None:
        """Stand still while a sensor is silent, else continue."""
        if self.base.silent.intersection(NEEDED):
            self.base.halt()
            self.base.drive(0.0, 0.0, TICK)
            self._check_limits(TICK)
        else:
            next(self._progress)

    def _end(self, code: Code, text: str = "") -> None:
        self.base.halt()
        self._progress.close()
        self.code, self.text = code, text or code.text
        if code is Code.docked:
            self.state, self.phase = GoalState.succeeded, Phase.docked
        elif code in (Code.cancelled, Code.preempted):
            self.state, self.phase = GoalState.preempted, Phase.idle
        else:
            self.state, self.phase = GoalState.aborted, Phase.failed

    # -- the phases: each `yield` is a tick ------------------------------------------------------------------------

    def _dock_robot(self) -> Ticks:
        """Attempt after attempt, a recovery before each but the first; returns when docked or raises DockingFailed."""
        remaining = attempts(self.settings)
        _, staging = next(remaining)
        place = staging if self.goal.navigate else None
        while True:
            try:
                yield from self._attempt(place)
                return
            except AttemptFailed:
                self.base.halt()
                recovery = next(remaining, None)
                if recovery is None:
                    raise
                self.recoveries.append(recovery[0])
                place = recovery[1]

    def _attempt(self, place: tuple[float, float] | None) -> Ticks:
        """Navigate to a place (metres before the dock, metres to its left), approach from there, wait for charge."""
        if place:
            yield from self._navigate_to(place)
        self.attempts += 1
        yield from self._approach_dock()
        yield from self._wait_for_charge()

    def _navigate_to(self, place: tuple[float, float]) -> Ticks:
        self.phase = Phase.recover if self.recoveries else Phase.staging
        self.navigator.set_goal(pose_before(self.goal.dock, *place))
        while True:
            status = self.navigator.tick()
            if status is NavStatus.arrived:
                return
            if status is not NavStatus.driving:
                raise FailedToStage(Code.nav_timeout if status is NavStatus.timed_out else Code.nav_blocked)
            self._check_limits(self.navigator.seconds / TICKS)
            yield

    def _approach_dock(self) -> Ticks:
        """The alignment drive until current flows. Limits: light, time, bumps."""
        settings, began, dark, bumps, turned = self.settings, self.seconds, 0.0, 0, 0.0
        self.phase, seen = Phase.acquire, False
        self.approach.restart()
        while True:
            self._signals = self.base.signals()
            dark = 0.0 if any(self._signals) else dark + TICK
            seen = seen or dark == 0.0
            if dark > (settings.approach.stuck if seen else settings.acquire):
                raise FailedToControl(Code.dock_lost_in_approach) if seen else FailedToDetectDock(Code.dock_not_seen)
            if self.seconds - began > settings.attempt:
                raise FailedToControl(Code.approach_timeout, self.approach.state.value)
            speed, turn = self.approach.tick(self._signals, turned)
            turned, bump = self._move(speed, turn)
            yield
            self.phase = Phase.approach if seen else Phase.acquire
            if bump and self.approach.state is not State.bumped:
                if (yield from self._wait_for_current()):
                    return
                bumps += 1
                if bumps >= settings.bumps:
                    aligned = self.approach.state is State.aligned_near
                    raise FailedToCharge(Code.no_charge_after_contact) if aligned else FailedToControl(Code.bump_limit)
                self.approach.bump()

    def _wait_for_current(self) -> Generator[None, None, bool]:
        """Stand against what was bumped into; returns whether current begins to flow."""
        self.phase = Phase.contact
        for _ in range(SETTLE):
            self._move(0.0, 0.0)
            yield
            if self.base.charging:
                return True
        return False

    def _wait_for_charge(self) -> Ticks:
        """Stand until current has flowed for `settings.charge` seconds."""
        self.phase, until = Phase.charge, self.seconds + self.settings.charge
        while self.seconds < until:
            if not self.base.charging:
                raise FailedToCharge(Code.charge_dropped)
            self._move(0.0, 0.0)
            yield

    def _move(self, speed: float, turn: float) -> tuple[float, bool]:
        """Drive one tick; returns (radians turned by the gyro, bumped)."""
        reading = self.base.drive(speed * TICK, turn * TICK, TICK)
        self.localiser.update(reading)
        self._check_limits(TICK)
        return reading.gyro if math.isfinite(reading.gyro) else 0.0, reading.bump is not None and speed > 0.0

    def _check_limits(self, seconds: float) -> None:
        """Count the time and raise DockingAborted at a limit."""
        self.seconds += seconds
        silent = sorted(self.base.silent.intersection(NEEDED))
        self._silent = self._silent + seconds if silent else 0.0
        if self.base.battery.empty:
            raise DockingAborted(Code.battery_empty)
        if self.base.hazard:
            raise DockingAborted(Code[self.base.hazard])
        if self._silent > self.settings.patience:
            raise DockingAborted(Code.sensor_silent, ", ".join(silent))
        if self.seconds > self.settings.action:
            raise DockingAborted(Code.deadline_passed)


def pose_before(dock: Pose, ahead: float, aside: float) -> Pose:
    """The pose `ahead` metres before the dock and `aside` metres to its left, facing it."""
    cosine, sine = math.cos(dock.yaw), math.sin(dock.yaw)
    x, y = dock.x + ahead * cosine - aside * sine, dock.y + ahead * sine + aside * cosine
    return Pose(x, y, math.atan2(dock.y - y, dock.x - x))
