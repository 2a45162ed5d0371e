"""Settings of the return to dock; conf/robot/turtlebot2i.yaml gives the source of each value."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from curionav_cli.bounds import bounded


class Recovery(Enum):
    """What is tried after a failed attempt, each followed by another one. Places are relative to the estimated dock.

    rescan: from where the robot stands. back_off, back_off_far: from 0.5 or 1 m farther out. sidestep_left,
    sidestep_right: from 0.5 m to the dock's left or right. restage: from the staging pose again. search: from five
    places in an arc, one attempt each.
    """

    rescan = "rescan"
    back_off = "back_off"
    back_off_far = "back_off_far"
    sidestep_left = "sidestep_left"
    sidestep_right = "sidestep_right"
    restage = "restage"
    search = "search"


@dataclass(frozen=True)
class InfraredLight:
    """The dock's sectors and the robot's receivers. range, near: metres, of the whole light and of the near sectors.

    Half angles in degrees. cone: of all sectors together; centre_sector: of the middle one, which reaches `overlap`
    into its neighbours; centre_width, side_width: of a receiver's field; side_axis: where the side receivers look.
    missed: share of the frames in which a receiver sees nothing.
    """

    range: float
    near: float
    cone: float
    centre_sector: float
    overlap: float
    centre_width: float
    side_axis: float
    side_width: float
    missed: float

    def __post_init__(self) -> None:
        bounded("robot.docking.infrared", self, {
            "range": (0, 10), "near": (0, self.range), "cone centre_sector overlap": (0, 90),
            "centre_width side_axis side_width": (0, 180), "missed": (0, 1)})


@dataclass(frozen=True)
class Contact:
    """Where the charging contacts meet: metres off the dock's axis and degrees off its direction, at most."""

    across: float
    angle: float

    def __post_init__(self) -> None:
        bounded("robot.docking.contact", self, {"across": (0, 1), "angle": (0, 180)})


@dataclass(frozen=True)
class Approach:
    """Speeds of the alignment drive, m/s and rad/s. stuck: seconds without any light that end an attempt."""

    scan: float
    crawl: float
    find: float
    stream: float
    far: float
    far_turn: float
    near: float
    near_turn: float
    stuck: float

    def __post_init__(self) -> None:
        bounded("robot.docking.approach", self, {
            "crawl stream far near": (0.001, 2), "scan find far_turn near_turn": (0.001, 6), "stuck": (0, 3600)})


@dataclass(frozen=True)
class ByLight:
    """Where attempts begin (staging: metres before the dock), and limits: seconds, but for the number of bumps.

    acquire: without any light since an attempt began; attempt: from there to contact; charge: how long current must
    flow; action: the whole return to dock; patience: with a silent sensor, and of the client with a silent server.
    """

    staging: float
    acquire: float
    attempt: float
    charge: float
    action: float
    patience: float
    bumps: int
    recoveries: list[Recovery]
    approach: Approach

    def __post_init__(self) -> None:
        bounded("robot.docking", self, {
            "staging": (0.4, 4), "acquire attempt charge action patience": (0, 3600), "bumps": (1, 1000)})


@dataclass(frozen=True)
class Docking(ByLight):
    """The same with the light and the contacts of a simulated dock."""

    infrared: InfraredLight
    contact: Contact
