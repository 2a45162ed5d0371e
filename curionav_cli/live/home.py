"""The way home of a real robot: to its dock by navigation and the base's docking action, or to its start."""

from __future__ import annotations

import math
from collections.abc import Callable

from curionav_cli.live.base import LiveBase
from curionav_cli.live.light import dock_by_light
from curionav_cli.live.safety import Displaced, Fault
from curionav_cli.records import DockReport, Pose
from curionav_cli.robot.docking.action import Code, GoalState
from curionav_cli.robot.docking.server import pose_before
from curionav_cli.robot.navigation import Navigator, NavStatus
from curionav_cli.robot.occupancy import Occupancy

ATTEMPTS = 2  # of the docking action, each from the staging pose
MOVE = 0.6  # seconds that a move counts for navigation, as one of the simulated robot takes
TOLD = 5.0  # seconds until the topic that tells follows
BACK_OFF = 0.5  # metres back from a dock, where the base has no action for it

Person = Callable[[str], None]  # asks a person to put the robot back, and returns when that is done


class Home:
    """Where an episode begins. place: the dock, facing the room, or the start. person: asked where the robot fails."""

    def __init__(self, base: LiveBase, place: Pose, radius: float, person: Person):
        self.base, self.place, self.radius, self.person = base, place, radius, person
        self.profile, self.clock = base.settings.profile, base.clock
        self.map, self.tries = Occupancy(), 0

    @property
    def has_dock(self) -> bool:
        """Whether the robot docks."""
        return self.profile.has_dock

    def begin(self) -> None:
        """Take the first place of a run, where a person has put the robot. Asks for it where it stands elsewhere."""
        self.base.allow_darkness(self.has_dock)
        if self.has_dock and self.docked() is False:
            self.person("The robot is not on its dock. Put it there.")
        self._know_place()

    def come_back(self, occupancy: Occupancy, lost: str = "") -> DockReport:
        """Return after an episode, on its map. lost: why nobody knows where the robot is; a person must put it back."""
        base, began, metres = self.base, self.clock.now(), self.base.metres
        away, share, self.map, self.tries = self._away(), base.battery.left, occupancy, 0
        recoveries: list[str] = []
        code, text = ("displaced", lost) if lost else self._return(recoveries)
        human = code != Code.docked.name
        if human:
            self._ask(text)
        if human or self.has_dock:
            self._know_place()
        return DockReport(code=code, text=text, human=human, attempts=self.tries, recoveries=tuple(recoveries),
                          seconds=self.clock.now() - began, metres=base.metres - metres, distance=away, battery=share)

    def _ask(self, why: str) -> None:
        """Have a person put the robot back, unless it stands on its dock already."""
        self.base.halt()
        self.base.allow_darkness(self.has_dock)
        if not self.docked():
            where = "on its dock" if self.has_dock else "back to its start, facing as it did"
            self.person(f"The robot could not return ({why}). Put it {where}.")

    def leave(self) -> None:
        """Charge where that is needed, then leave the dock. Raises Fault where the camera stays dark."""
        base = self.base
        if self.has_dock:
            self._recharge()
            self._undock()
        base.wait_for("the camera sends nothing", base.sensors.seeing, base.settings.patience)
        base.allow_darkness(False)

    def docked(self) -> bool | None:
        """Whether the dock is touched, once the robot has said so; None where it has no topic for it."""
        if not self.profile.docked.name:
            return None
        self.base.wait_for(f"{self.profile.docked.name} is silent", lambda: self.base.sensors.docked() is not None,
                           self.base.settings.patience)
        return self.base.sensors.docked()

    def _know_place(self) -> None:
        """Set the estimate to the dock, or the start."""
        self.base.follow()
        self.base.localiser.time = -math.inf  # the base's clock may have started anew
        self.base.localiser.leave_dock(self.base.docked_pose(self.place) if self.has_dock else self.place)

    def _return(self, recoveries: list[str]) -> tuple[str, str]:
        """Drive home; returns the code and its words."""
        if not self.has_dock:
            status = self._navigate(self.place)
            return outcome(status) or (Code.docked.name, "back at its start; this robot has no dock")
        if self.profile.by_light:
            return self._by_light(recoveries)
        failed = self._attempt()
        while failed and self.tries < ATTEMPTS and not failed[0].startswith("nav_"):
            recoveries.append("restage")
            failed = self._attempt()
        return failed or (Code.docked.name, Code.docked.text)

    def _attempt(self) -> tuple[str, str] | None:
        """Drive to the staging pose and dock from there; returns what failed, or None."""
        return outcome(self._navigate(pose_before(self.place, self.profile.staging, 0.0))) or self._dock()

    def _by_light(self, recoveries: list[str]) -> tuple[str, str]:
        """Drive home and dock by our own server."""
        server = dock_by_light(self.base, self._navigator(), self.place)
        self.tries = server.attempts
        recoveries += server.recoveries
        assert server.code is not None
        return server.code.name, server.text

    def _navigator(self) -> Navigator:
        return Navigator(self.base, self.base.localiser, self.map, self.radius, MOVE, ticks=1)

    def _navigate(self, goal: Pose) -> NavStatus:
        base, navigator = self.base, self._navigator()
        navigator.set_goal(goal)
        while navigator.tick() is NavStatus.driving:
            if base.hazard:
                raise Displaced(f"{base.hazard.replace('_', ' ')} on the way home")
        base.halt()
        return navigator.status

    def _dock(self) -> tuple[str, str] | None:
        """Have the base dock; returns what failed, or None."""
        base = self.base
        self.tries += 1
        base.allow_darkness(True)
        state = base.wheels.act(self.profile.dock, {}, base.settings.homing, base.pause)
        if state is GoalState.succeeded and self._comes_to_be(docked=True):
            return None
        base.allow_darkness(False)
        return f"action_{state.value}", f"the docking action was {state.value}{base.wheels.answer}" if \
            state is not GoalState.succeeded else "the docking action succeeded, and the robot is not docked"

    def _undock(self) -> None:
        base, action = self.base, self.profile.undock
        if not action.name:
            base.mover.forward(-BACK_OFF, base.pause)
            base.mover.turn(math.pi, base.pause)
            return
        state = base.wheels.act(action, {}, base.settings.homing, base.pause)
        if state is not GoalState.succeeded or not self._comes_to_be(docked=False):
            raise Fault(f"the robot did not leave its dock: {action.name} was {state.value}{base.wheels.answer}")

    def _comes_to_be(self, docked: bool) -> bool:
        """Whether the robot says within TOLD seconds that it is docked, or is not; True where nothing tells."""
        until = self.clock.now() + TOLD
        while self.docked() is (not docked) and self.clock.now() < until:
            self.base.pause()
        return self.docked() is not (not docked)

    def _recharge(self) -> None:
        """Wait on the dock where the battery is near the reserve."""
        settings, base = self.base.settings, self.base
        share = base.sensors.charge()
        if share is None or share > settings.reserve:
            return
        while (base.sensors.charge() or 0.0) < settings.recharge:
            base.pause()

    def _away(self) -> float:
        here = self.base.localiser.pose
        return math.hypot(here.x - self.place.x, here.y - self.place.y)


def outcome(status: NavStatus) -> tuple[str, str] | None:
    """The code and words of a navigation that failed; None for one that arrived."""
    if status is NavStatus.arrived:
        return None
    code = Code.nav_timeout if status is NavStatus.timed_out else Code.nav_blocked
    return code.name, code.text
