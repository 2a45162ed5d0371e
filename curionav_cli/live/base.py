"""A real robot as navigation uses it (robot.interface.Base), with its estimate and its safety checks in one place."""

from __future__ import annotations

import math
from dataclasses import dataclass

from curionav_cli.live.clock import Clock
from curionav_cli.live.contacts import side_of
from curionav_cli.live.safety import Fault
from curionav_cli.live.sensors import SILENT_ON_DOCK, Sensors
from curionav_cli.live.settings import Rosbridge
from curionav_cli.live.transport import Transport
from curionav_cli.live.wheels import PERIOD, Wheels, mover
from curionav_cli.records import Pose
from curionav_cli.robot.localiser import Localiser
from curionav_cli.robot.measurements import Reading, Scan, Signals
from curionav_cli.world.real_floor import RealFloor


@dataclass
class Charge:
    """interface.Battery by the share that the robot reports. left: of a capacity of 1; 1 where it reports nothing."""

    left: float
    capacity: float = 1.0

    @property
    def empty(self) -> bool:
        return self.left <= 0.0


class LiveBase:
    """The base of a real robot (interface.Base). localiser: follows every motion, whoever commands it."""

    def __init__(self, transport: Transport, settings: Rosbridge, floor: RealFloor, sensors: Sensors, clock: Clock):
        self.transport, self.settings, self.sensors, self.clock = transport, settings, sensors, clock
        self.wheels = Wheels(transport, sensors, settings, clock)
        self.mover = mover(self.wheels)
        self.localiser = Localiser(settings, floor.plan.start)
        self.without: tuple[str, ...] = ()  # topics that may be silent now
        self.metres = 0.0

    def pause(self) -> None:
        """Let a moment pass. Raises Fault where the robot must stop: safety.py lists the causes."""
        self.clock.sleep(PERIOD)
        self.follow()
        if not self.transport.is_alive():
            raise Fault("the connection to the robot is lost")
        self.wheels.check()
        self.sensors.check(self.without)

    def follow(self, bump: str | None = None) -> None:
        """Move the estimate by what odometry and gyro have measured since."""
        reading = self.sensors.travel.reading(bump)
        if reading is not None:
            self.localiser.update(reading)
            self.metres += abs(reading.wheel)

    def wait_for(self, what: str, ready, seconds: float) -> None:
        """Pause until `ready()`. Raises Fault, which names `what`, after `seconds`."""
        until = self.clock.now() + seconds
        while not ready():
            if self.clock.now() > until:
                raise Fault(f"{what} for {seconds:g} s")
            self.pause()

    def wait_for_view(self) -> None:
        """Wait until all that an observation is made of was taken after the last odometry."""
        now = self.sensors.travel.now
        stamp = now.stamp if now else 0.0
        self.wait_for("no image newer than the last move", lambda: self.sensors.seen_since(stamp), self.settings.stale)

    # -- interface.Base -------------------------------------------------------------------------------------------

    @property
    def hazard(self) -> str | None:
        names = ("wheel_drop", "cliff")
        now = self.sensors.touching.items()
        return next((name for name in names if any(on and key.startswith(name) for key, on in now)), None)

    @property
    def velocity(self) -> tuple[float, float]:
        return self.wheels.velocity

    @property
    def battery(self) -> Charge:
        share = self.sensors.charge()
        return Charge(1.0 if share is None else share)

    @property
    def silent(self) -> set[str]:
        """Only what docking alone needs: other sensors that are silent are a Fault."""
        by_light = self.settings.profile.by_light
        return {"infrared"} if by_light and self.sensors.age("dock_ir") > self.settings.stale else set()

    @property
    def charging(self) -> bool:
        return bool(self.sensors.docked())

    def drive(self, distance: float, turn: float, seconds: float) -> Reading:
        """Drive a part of a move; what it measured is already in the estimate, so the reading is empty of motion."""
        self.sensors.bumped()
        if turn:
            self.mover.turn(turn, self.pause)
        if distance:
            self.mover.forward(distance, self.pause)
        self.wait_for_view()
        bump = side_of(self.sensors.bumped()) if distance > 0.0 else None
        now = self.sensors.travel.now
        return Reading(0.0, 0.0, max(seconds, PERIOD), now.stamp if now else 0.0, bump)

    def halt(self) -> None:
        self.wheels.halt()

    def scan(self) -> Scan:
        return self.sensors.around()

    def depth(self) -> Scan:
        return self.sensors.ahead()

    def signals(self) -> Signals:
        return self.sensors.signals()

    # -- docked ---------------------------------------------------------------------------------------------------

    def allow_darkness(self, allowed: bool) -> None:
        """Let the camera be silent, as it is on some docks."""
        self.without = SILENT_ON_DOCK if allowed else ()

    def docked_pose(self, dock: Pose) -> Pose:
        """The pose of a robot that stands on its dock, its front to the station."""
        return Pose(dock.x, dock.y, dock.yaw + math.pi)
