"""Settings of a scene: conf/env/*.yaml."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from curionav_cli.bounds import a_name, a_number

RANGES = {
    "radius": (0.0, 5.0), "camera": (0.01, 10.0), "height": (0.1, 20.0), "agent_height": (0.01, 10.0),
    "fov": (20.0, 150.0), "cell": (0.01, 2.0), "unknown_grey": (0, 255), "visitable": (1, 10**9),
    "scale_occupied": (1, 100), "visitable_radius": (0.0, 5.0),
}
OPTIONAL = ("cell", "unknown_grey", "visitable", "visitable_radius")


class Collision(Enum):
    """A forward move that would collide is not made, ends at the obstacle, or slides along it (Habitat)."""

    cancel = "cancel"
    stop = "stop"
    slide = "slide"


class Engine(Enum):
    """The rendering engine: numpy, always installed, or numba, faster, from the extra `fast`."""

    numpy = "numpy"
    numba = "numba"


@dataclass(frozen=True)
class Env:
    """A scene in metres and degrees; world/scene/scene_format.py explains the lists.

    A scene either has a `size` or opens a ROS `map`. `visitable` is a promise about the number of
    cells a robot of `visitable_radius` can reach: a scene that breaks it does not load.
    """

    name: str
    radius: float
    camera: float  # height of the camera above the floor
    note: str = ""
    size: list[float] | None = None  # x and y of the inside
    map: str | None = None  # the YAML file of a ROS map
    overlay: str | None = None  # a YAML file with what the map does not hold: the lists below, start, dock
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
    solids: list[Any] = field(default_factory=list)  # heights and materials of cells that a map shows as occupied
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
        for key, (least, most) in RANGES.items():
            if getattr(self, key) is not None or key not in OPTIONAL:
                a_number(f"env.{key}", getattr(self, key), least, most)
        if self.camera >= self.height:
            raise ValueError(f"env.camera ({self.camera:g} m) must be below the ceiling, "
                             f"env.height ({self.height:g} m)")


@dataclass(frozen=True)
class Live(Env):
    """A real floor: no scene, and no list of one is used.

    floor: a ROS map of it, whose reachable cells are the denominator of coverage; `start` is then a pose in it. extent:
    without one, metres around the start within which cells are counted.
    """

    floor: str | None = None
    extent: float = 12.0

    def __post_init__(self) -> None:
        super().__post_init__()
        a_number("env.extent", self.extent, 1.0, 100.0)
        if self.map or self.size:
            raise ValueError("env.map, env.size: a real floor has no scene. To count the cells of a map: "
                             "env.floor=PATH.yaml")
        if self.floor and not self.start:
            raise ValueError("env.start: with env.floor, say where on that map the robot begins, "
                             "env.start=[x, y, degrees]")


UPS = ("auto", "x", "y", "z", "-x", "-y", "-z")


@dataclass(frozen=True)
class Scan(Env):
    """A building as a mesh of triangles (docs/scans.md). Metres, degrees; `start` and `dock` in the file's own axes.

    up: the file's axis that points up; auto: y of GLB, glTF and OBJ, z of PLY and STL. scale: metres in one unit of the
    file; none: metres. storey: which floor, 0 the lowest; level: its height instead, metres. step: obstacles are what
    stands higher above the floor than this; slope: what is steeper is no floor.
    """

    mesh: str | None = None
    up: str = "auto"
    scale: float | None = None
    storey: int = 0
    level: float | None = None
    step: float = 0.03
    slope: float = 30.0
    counted: int | None = None  # cells that others counted there, which `curionav sheet` prints beside ours
    haze: float = 0.0  # light left at depth d: 1 / (1 + haze d); 0.035 in the worlds of boxes

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.up not in UPS:
            raise ValueError(f"env.up must be one of {', '.join(UPS)}, not {self.up!r}")
        for key, (least, most) in {"storey": (0, 100), "step": (0.001, 0.5), "slope": (1.0, 60.0),
                                   "haze": (0.0, 1.0)}.items():
            a_number(f"env.{key}", getattr(self, key), least, most)
        for key, (least, most) in {"scale": (1e-6, 1e3), "level": (-1e4, 1e4), "counted": (1, 10**9)}.items():
            if getattr(self, key) is not None:
                a_number(f"env.{key}", getattr(self, key), least, most)
        if self.step >= self.agent_height:
            raise ValueError(f"env.step ({self.step:g} m) must be below env.agent_height ({self.agent_height:g} m)")
