"""Settings of a real robot; conf/robot/rosbridge.yaml and conf/robot/profile/ have their values."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

from curionav_cli.bounds import bounded
from curionav_cli.robot.docking_settings import ByLight
from curionav_cli.robot.settings import Filter, Gyro, Localisation, Odometry, Robot


@dataclass(frozen=True)
class Topic:
    """A topic or an action: its name, without the namespace, and its type. No name: the robot has none."""

    name: str = ""
    type: str = ""

    def __post_init__(self) -> None:
        if self.name and not self.type:
            raise ValueError(f"robot.profile: {self.name} has no type, such as sensor_msgs/msg/Image")


@dataclass(frozen=True)
class View(Topic):
    """Images of a camera. crop: the side of the square in their middle that is used, as a share of the shorter side."""

    crop: float = 1.0

    def __post_init__(self) -> None:
        super().__post_init__()
        bounded(f"robot.profile ({self.name})", self, {"crop": (0.05, 1)})


@dataclass(frozen=True)
class Scanner(Topic):
    """A laser scanner. turned: degrees to the left by which its zero lies from straight ahead."""

    turned: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        bounded("robot.profile.scan", self, {"turned": (-360, 360)})


SENDING = ("image", "depth", "scan", "odom", "imu", "battery", "docked", "dock_ir")  # topics of a profile


@dataclass(frozen=True)
class Profile:
    """What a kind of robot calls its topics and actions.

    ros: 1 or 2. imu, scan, depth and battery may be absent, but one of scan and depth is needed. contacts: topics of
    bumpers, cliff sensors and wheel drops, name to type. It moves by `velocity`, or where `drive` and `turn` have names
    by these actions. dock: the action by which it docks from `staging` metres before the dock. Without one it docks by
    the infrared light that dock_ir tells of (docking/server.py), and without both an episode begins at the start.
    undock: without one it backs off and turns round. docked: the topic that tells.
    """

    name: str
    ros: int
    image: View
    odom: Topic
    velocity: Topic
    depth: View = field(default_factory=View)
    scan: Scanner = field(default_factory=Scanner)
    imu: Topic = field(default_factory=Topic)
    battery: Topic = field(default_factory=Topic)
    docked: Topic = field(default_factory=Topic)
    dock_ir: Topic = field(default_factory=Topic)
    contacts: dict[str, str] = field(default_factory=dict)
    drive: Topic = field(default_factory=Topic)
    turn: Topic = field(default_factory=Topic)
    dock: Topic = field(default_factory=Topic)
    undock: Topic = field(default_factory=Topic)
    staging: float = 1.0

    @property
    def by_actions(self) -> bool:
        """Whether moves are actions of the base."""
        return bool(self.drive.name)

    @property
    def by_light(self) -> bool:
        """Whether it docks by our own server."""
        return bool(self.dock_ir.name) and not self.dock.name

    @property
    def has_dock(self) -> bool:
        """Whether it docks at all."""
        return bool(self.dock.name) or self.by_light

    def topics(self) -> dict[str, Topic]:
        """The topics that it sends, by what they are."""
        named = {key: getattr(self, key) for key in SENDING}
        touch = {f"contact {name}": Topic(name, kind) for name, kind in self.contacts.items()}
        return {key: topic for key, topic in {**named, **touch}.items() if topic.name}

    def actions(self) -> dict[str, Topic]:
        """The actions that it offers, by what they do."""
        named = {key: getattr(self, key) for key in ("drive", "turn", "dock", "undock")}
        return {key: topic for key, topic in named.items() if topic.name}

    def __post_init__(self) -> None:
        bounded("robot.profile", self, {"ros": (1, 2), "staging": (0.4, 4)})
        for key in ("image", "odom", "velocity"):
            if not getattr(self, key).name:
                raise ValueError(f"robot.profile.{key}.name: every robot needs this topic")
        if not self.depth.name and not self.scan.name:
            raise ValueError("robot.profile: without depth.name and scan.name it would drive blind; name one of them")
        if bool(self.drive.name) != bool(self.turn.name):
            raise ValueError("robot.profile: drive and turn are both actions or neither is")
        if self.by_light and not self.docked.name:
            raise ValueError("robot.profile: docking by dock_ir needs docked.name, the topic that tells of the contact")


class Twist(Enum):
    """The type of velocity commands: with a header (ROS 2 Jazzy and later), without, or what the bridge says."""

    auto = "auto"
    stamped = "stamped"
    plain = "plain"


@dataclass(frozen=True)
class Rosbridge(Robot):
    """A real robot, reached through a rosbridge server.

    host, port: of the server. namespace: before every name of the profile. connect: seconds to wait for it. stale:
    seconds without a new image or odometry after which the robot is stopped and the episode ends. patience: seconds to
    wait then for the robot to come back. move: seconds of a move at most. max_speed (m/s), max_turn (degrees/s).
    geofence: metres around the dock. reserve, recharge: shares of the battery; an episode ends at `reserve`, and the
    next one begins at `recharge` where it had fallen so low. homing: seconds of a docking action. docking: that by
    light. dry_run: print what
    would be sent and send nothing. odometry, gyro, filter: the errors that the estimate of the pose reckons with.
    """

    profile: Profile
    host: str
    port: int
    namespace: str
    twist: Twist
    connect: float
    stale: float
    patience: float
    move: float
    max_speed: float
    max_turn: float
    geofence: float
    reserve: float
    recharge: float
    homing: float
    docking: ByLight
    dry_run: bool
    odometry: Odometry
    gyro: Gyro
    filter: Filter

    localisation = Localisation.none  # for the Localiser: scans are used for the map only

    def __post_init__(self) -> None:
        bounded("robot", self, {
            "port": (1, 65535), "connect stale patience move": (0.1, 3600), "max_speed": (0.01, 2),
            "max_turn": (1, 360), "geofence": (0.5, 1000), "reserve": (0, 0.95), "recharge": (self.reserve, 1),
            "homing": (1, 3600)})


LINK = ("host", "port", "connect", "stale", "patience", "max_speed", "max_turn", "geofence", "reserve", "recharge",
        "homing", "docking")  # may change when a run is resumed: where the robot is, and how careful one is with it
