"""Docking of a real robot by our own server: the dock's infrared light over a topic, and velocity commands."""

from __future__ import annotations

from curionav_cli.live.base import Charge, LiveBase
from curionav_cli.live.contacts import side_of
from curionav_cli.records import Pose
from curionav_cli.robot.docking.action import Goal, Phase
from curionav_cli.robot.docking.server import DockingServer
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.measurements import Reading, Scan, Signals
from curionav_cli.robot.navigation import Navigator

DRIVING = (Phase.staging, Phase.recover)  # phases of navigation, which needs the camera


class Approaching:
    """A real robot as the approach uses it (interface.Docker): each drive is a velocity command of a short time."""

    def __init__(self, base: LiveBase):
        self.base = base

    @property
    def hazard(self) -> str | None:
        return self.base.hazard

    @property
    def battery(self) -> Charge:
        return self.base.battery

    @property
    def silent(self) -> set[str]:
        return self.base.silent

    @property
    def charging(self) -> bool:
        return self.base.charging

    def drive(self, distance: float, turn: float, seconds: float) -> Reading:
        """Command a velocity and let it last; returns what was measured then. Raises Fault."""
        base, travel = self.base, self.base.sensors.travel
        forward, heading, began = travel.forward, travel.heading, base.clock.now()
        base.sensors.bumped()
        base.wheels.send(distance / seconds, turn / seconds)
        while base.clock.now() < began + seconds - 1e-6:
            base.pause()
        time = travel.now.stamp if travel.now else 0.0
        touched = side_of(base.sensors.bumped()) or ("centre" if base.charging else None)  # some have no bumper
        return Reading(travel.forward - forward, travel.heading - heading, seconds, time, touched)

    def halt(self) -> None:
        self.base.halt()

    def signals(self) -> Signals:
        return self.base.signals()


class Followed:
    """The estimate of a base that follows each motion by itself (interface.Estimate): readings add nothing to it."""

    def __init__(self, localiser: Localiser):
        self.localiser = localiser

    @property
    def pose(self) -> Pose:
        return self.localiser.pose

    def update(self, reading: Reading, scan: Scan | None = None) -> None:
        """Do nothing: LiveBase.follow has been called."""


def dock_by_light(base: LiveBase, navigator: Navigator, dock: Pose) -> DockingServer:
    """Drive to the staging pose and dock, with recoveries; returns the server at its end. Raises Fault."""
    server = DockingServer(Approaching(base), Followed(base.localiser), navigator, base.settings.docking)
    server.request(Goal(dock))
    try:
        while server.code is None:
            server.tick()
            base.allow_darkness(server.phase not in DRIVING)
    finally:
        base.allow_darkness(False)
        base.halt()
    return server
