"""What client and server say to each other: goal, feedback, and the names of all that can go wrong.

Names and numbers follow the docking server of Nav2 (opennav_docking) where it has them: 902 to 906. What it does not
tell apart gets a name and 900 of its own kind here.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple, Protocol

from curionav_cli.records import Pose
from curionav_cli.robot.infrared import Signals
from curionav_cli.robot.measurements import Scan, Sensed


class Code(Enum):
    """How a homecoming ends, with the number of Nav2's docking server (0 success, 999 what it has no word for)."""

    docked = 0
    nav_timeout = 903, "the staging pose was not reached in time"
    nav_blocked = 903, "no way leads to the staging pose"
    dock_not_seen = 904, "no infrared light was seen"
    dock_lost_in_approach = 905, "the infrared light was lost"
    approach_timeout = 905, "the approach took too long"
    bump_limit = 905, "something was bumped into too often"
    no_charge_after_contact = 906, "contact without current"
    charge_dropped = 906, "the current stopped"
    battery_empty = 999, "the battery is empty"
    deadline_passed = 999, "the whole homecoming took too long"
    sensor_silent = 999, "a sensor is silent"
    wheel_drop = 999, "a wheel hangs in the air"
    cliff = 999, "there is a step in the floor"
    cancelled = 999, "cancelled"
    preempted = 999, "another goal came"
    server_lost = 999, "the docking server is silent"

    def __init__(self, number: int, text: str = "docked"):
        self.number, self.text = number, text

    def __new__(cls, *parts: Any) -> Code:
        code = object.__new__(cls)
        code._value_ = len(cls.__members__)  # equal numbers are no aliases
        return code


# After these another attempt may help.
RECOVERABLE = frozenset({
    Code.nav_timeout, Code.nav_blocked, Code.dock_not_seen, Code.dock_lost_in_approach, Code.approach_timeout,
    Code.bump_limit, Code.no_charge_after_contact, Code.charge_dropped})


class Failed(Exception):
    """An attempt, or the whole homecoming, ended with a code that is not `docked`."""

    def __init__(self, code: Code, detail: str = ""):
        super().__init__(f"{code.text}{f' ({detail})' if detail else ''}")
        self.code = code


class GoalState(Enum):
    """As in actionlib."""

    pending = "pending"
    active = "active"
    preempting = "preempting"
    succeeded = "succeeded"
    aborted = "aborted"
    preempted = "preempted"
    rejected = "rejected"
    lost = "lost"


class Phase(Enum):
    idle = "idle"
    staging = "nav_to_staging"
    acquire = "acquire"
    approach = "approach"
    contact = "contact"
    charge = "wait_for_charge"
    recover = "recover"
    docked = "docked"
    failed = "human_intervention"


@dataclass(frozen=True)
class Goal:
    """dock: its pose as believed, in the robot's frame. navigate: drive to the staging pose first."""

    dock: Pose
    navigate: bool = True
    dock_id: str = "dock"


class Feedback(NamedTuple):
    """Five or more a second. elapsed: seconds; signals: infrared bits; distance: metres to the dock, estimated."""

    phase: Phase
    drive: str
    attempt: int
    elapsed: float
    signals: Signals
    distance: float


class Battery(Protocol):
    """Seconds of driving."""

    left: float
    capacity: float

    @property
    def empty(self) -> bool:
        """Can it drive no more?"""


class Base(Protocol):
    """What homing and docking may touch of a robot: motors and sensors. None of it tells where the robot is.

    silent: names of sensors that send nothing; hazard: "wheel_drop", "cliff" or None; charging: does current flow?
    """

    hazard: str | None

    @property
    def velocity(self) -> tuple[float, float]:
        """Of the last command, m/s and rad/s."""

    @property
    def battery(self) -> Battery:
        """Of this robot."""

    @property
    def silent(self) -> set[str]:
        """Which sensors are silent."""

    @property
    def charging(self) -> bool:
        """Is there current?"""

    def drive(self, distance: float, turn: float, seconds: float) -> Sensed:
        """A short arc: metres, radians to the left."""

    def halt(self) -> None:
        """Zero velocity."""

    def scan(self) -> Scan:
        """The LiDAR, all around."""

    def depth(self) -> Scan:
        """The depth camera's horizontal line."""

    def signals(self) -> Signals:
        """One more frame of the infrared receivers."""
