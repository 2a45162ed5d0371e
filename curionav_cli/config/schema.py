"""Every setting's type and range, as plain dataclasses; the values stand in conf/, once.

A field without a default has its value in a YAML file. __post_init__ raises ValueError with
'key: what is wrong' for a value that its type allows and its meaning does not.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from curionav_cli.config.bounds import a_name, bounded, within


class Device(Enum):
    """Where tensors live; auto takes a CUDA device if there is one."""

    auto = "auto"
    cpu = "cpu"
    cuda = "cuda"


class Compile(Enum):
    """How updates run on a CUDA device: none, kernel by kernel; graph, as CUDA graphs; fused, as graphs of fewer
    kernels, which torch.compile makes. auto is fused there, or graph where a compiler is missing."""

    auto = "auto"
    none = "none"
    graph = "graph"
    fused = "fused"


class Learner(Enum):
    """local: in this process; remote: episodes go to `storage`, where curionav train learns, and weights come back."""

    local = "local"
    remote = "remote"


class Logger(Enum):
    """Where metrics go beside metrics.jsonl: nowhere, or to TensorBoard's files in the run folder."""

    local = "local"
    tensorboard = "tensorboard"


class Scale(Enum):
    """cpu: minutes on two cores; paper: the paper's hyperparameter table."""

    cpu = "cpu"
    paper = "paper"


@dataclass(frozen=True)
class Loop:
    """One life: `episodes` times N `steps` of acting, then K `iterations` of learning.

    `train` does not act: `iterations` are all that it does.
    """

    steps: int
    iterations: int
    episodes: int
    replay_memory: float  # GB of frames; the others are read from the disk

    def __post_init__(self) -> None:
        bounded("loop", self, {"steps episodes": (1, 10**6), "iterations": (0, 10**9), "replay_memory": (0, 10**6)})


@dataclass(frozen=True)
class Dock:
    """What `curionav dock` does: so many homecomings, each after an episode of loop.steps."""

    requests: int = 600

    def __post_init__(self) -> None:
        bounded("dock", self, {"requests": (1, 10**6)})


@dataclass(frozen=True)
class Robot:
    """ideal: perfect motion, put back to the start after each episode. The others: robot_schema.py."""

    name: str


class Collision(Enum):
    """A forward move that would hit something: is not made, ends there, or slides along (Habitat)."""

    cancel = "cancel"
    stop = "stop"
    slide = "slide"


class Engine(Enum):
    """What draws the pictures: numpy, always there, or numba, faster, from the extra `fast`."""

    numpy = "numpy"
    numba = "numba"


@dataclass(frozen=True)
class Env:
    """A scene in metres and degrees; world/scene_format.py explains the lists.

    A scene either has a `size` or opens a ROS `map`. `visitable` is a promise about the number of
    cells a robot of `visitable_radius` can reach: a scene that breaks it does not load.
    """

    name: str
    radius: float
    camera: float  # height of the camera above the floor
    note: str = ""
    size: list[float] | None = None  # x and y of the inside
    map: str | None = None  # the YAML file of a ROS map
    overlay: str | None = None  # a YAML file with what the map does not know: the lists below, start, dock
    unknown_grey: int | None = None  # the grey value that means unknown, whatever the thresholds say
    scale_occupied: int = 100  # of a map in mode scale or raw: the value, 1 to 100, from which a cell is a wall
    cell: float | None = None  # of the coverage grid; none: that of the map
    height: float = 2.5
    agent_height: float = 0.5
    fov: float = 79.0
    collision: Collision = Collision.cancel
    start: list[float] | None = None  # x, y, degrees; none: the roomiest place
    dock: list[float] | None = None  # none: the start
    visitable: int | None = None
    visitable_radius: float | None = None  # none: the radius above
    visitable_sha256: str | None = None
    rooms: list[Any] = field(default_factory=list)
    walls: list[Any] = field(default_factory=list)
    solids: list[Any] = field(default_factory=list)  # heights and materials of what a map shows as occupied
    posters: list[Any] = field(default_factory=list)
    lamps: list[Any] = field(default_factory=list)
    furniture: list[Any] = field(default_factory=list)
    repeat: list[Any] = field(default_factory=list)
    tune: dict[str, Any] = field(default_factory=dict)
    light: dict[str, Any] = field(default_factory=dict)
    moves: list[Any] = field(default_factory=list)
    engine: Engine = Engine.numpy
    changes: bool = True  # false: neither light nor moves, whatever stands there

    def __post_init__(self) -> None:
        a_name("env.name", self.name)


@dataclass(frozen=True)
class Remote:
    """How robot and server wait for each other, in seconds; and what a robot keeps that could not be delivered."""

    wait: float
    offline: float
    poll: float
    timeout: float
    gap: float
    outbox: int
    disk: float
    follow: bool

    def __post_init__(self) -> None:
        bounded("remote", self, {
            "wait offline gap": (0, 10**9), "poll": (0.01, 86400), "timeout": (0.1, 86400), "outbox": (1, 10**6),
            "disk": (0, 1)})


@dataclass(frozen=True)
class Config:
    """All settings of one run. `agent` and `robot` are the dataclasses of the chosen ones."""

    seed: int
    device: Device
    compile: Compile
    scale: Scale
    data: str | None  # the folder whose episodes `train` learns from
    learner: Learner
    storage: str | None  # a URL: where robot and server meet
    remote: Remote
    loop: Loop
    env: Env
    agent: Any
    robot: Any
    dock: Dock = field(default_factory=Dock)
    question: str | None = None  # what a sweep is to answer, in a sentence: the page that compare writes begins with it
    logger: Logger = Logger.local  # a run of an earlier version says nothing of it

    def __post_init__(self) -> None:
        within("seed", self.seed, least=0, most=2**32 - 1)
