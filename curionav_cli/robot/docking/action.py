"""The docking action: goal, feedback, result codes, and the failures that the server raises.

    DockingFailed
     |- AttemptFailed           followed by the next recovery, as long as there is one
     |   |- FailedToStage       903: nav_timeout, nav_blocked
     |   |- FailedToDetectDock  904: dock_not_seen
     |   |- FailedToControl     905: dock_lost_in_approach, approach_timeout, bump_limit
     |   |- FailedToCharge      906: no_charge_after_contact, charge_dropped
     |- DockingAborted          999: at once, in any phase

Names and numbers are those of Nav2's docking server (opennav_docking), 903 to 906; the codes below divide them further.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple

from curionav_cli.records import Pose
from curionav_cli.robot.measurements import Signals

NOT_IN_NAV2 = 999  # Nav2's UNKNOWN, for failures that it does not name; no further attempt is made


class Code(Enum):
    """How a return to dock ends, with the number of Nav2's docking server (0 success, 999 Nav2's UNKNOWN)."""

    docked = 0
    nav_timeout = 903, "the staging pose was not reached in time"
    nav_blocked = 903, "no way leads to the staging pose"
    dock_not_seen = 904, "no infrared light was seen"
    dock_lost_in_approach = 905, "the infrared light was lost"
    approach_timeout = 905, "the approach took too long"
    bump_limit = 905, "something was bumped into too often"
    no_charge_after_contact = 906, "contact without current"
    charge_dropped = 906, "the current stopped"
    battery_empty = NOT_IN_NAV2, "the battery is empty"
    deadline_passed = NOT_IN_NAV2, "the return to dock took too long"
    sensor_silent = NOT_IN_NAV2, "a sensor is silent"
    wheel_drop = NOT_IN_NAV2, "a wheel hangs in the air"
    cliff = NOT_IN_NAV2, "there is a step in the floor"
    cancelled = NOT_IN_NAV2, "cancelled"
    preempted = NOT_IN_NAV2, "another goal came"
    server_lost = NOT_IN_NAV2, "the docking server is silent"

    def __init__(self, number: int, text: str = "docked"):
        self.number, self.text = number, text

    def __new__(cls, *parts: Any) -> Code:
        code = object.__new__(cls)
        code._value_ = len(cls.__members__)  # equal numbers are no aliases
        return code


class DockingFailed(Exception):
    """A failure of docking: `code` says which, the message adds `detail`."""

    def __init__(self, code: Code, detail: str = ""):
        super().__init__(f"{code.text}{f' ({detail})' if detail else ''}")
        self.code = code


class AttemptFailed(DockingFailed):
    """An attempt has failed; another one, from another place, may succeed."""


class FailedToStage(AttemptFailed):
    """The staging pose was not reached."""


class FailedToDetectDock(AttemptFailed):
    """No infrared light was seen."""


class FailedToControl(AttemptFailed):
    """The approach did not lead to the contacts."""


class FailedToCharge(AttemptFailed):
    """The contacts met, and no current flows."""


class DockingAborted(DockingFailed):
    """No further attempt is made: empty battery, silent sensor, hazard, deadline."""


class GoalState(Enum):
    """The states of a goal, as in actionlib."""

    pending = "pending"
    active = "active"
    preempting = "preempting"
    succeeded = "succeeded"
    aborted = "aborted"
    preempted = "preempted"
    rejected = "rejected"
    lost = "lost"


class Phase(Enum):
    """What the server is doing, in feedback and in the docking diagram."""

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
    """A request to dock. dock: its estimated pose, in the robot's frame. navigate: drive to the staging pose first."""

    dock: Pose
    navigate: bool = True
    dock_id: str = "dock"


class Feedback(NamedTuple):
    """Progress, at least five times a second. drive: the state of the approach; elapsed: seconds; signals: infrared
    bits; distance: estimated metres to the dock."""

    phase: Phase
    drive: str
    attempt: int
    elapsed: float
    signals: Signals
    distance: float
