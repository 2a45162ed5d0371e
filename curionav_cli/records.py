"""The nouns that travel between rooms: Pose, FloorPlan, Episode, DockReport, Prediction. Each can be saved and loaded.

Frames. x points right and y up, in metres from the lower-left corner of the scene (for a ROS map: of its image, or of
the part of it that a large map is cropped to); yaw is counter-clockwise from +x in radians. Cell (row, column) covers
[column, column + 1) * cell in x and [row, row + 1) * cell in y, so row 0 is the lowest.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from curionav_cli.constants import ACTIONS, IMAGE_SHAPE
from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_arrays, understood, write_arrays


class Pose(NamedTuple):
    """Position in metres and yaw in radians, see the module for the frame."""

    x: float
    y: float
    yaw: float


ORIGIN = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class FloorPlan:
    """What is left of a scene once it has been lived in: enough to count coverage and to draw it.

    visitable, floor, solid: (rows, columns) bool. `visitable` are the cells whose centre the robot
    can reach, `floor` every cell of the building, `solid` those covered by a wall or furniture.
    occupancy: (rows, columns) int8 of a ROS map, -1 unknown, 0 free to 100 occupied; None of a scene. dock: None: the
    start.
    """

    visitable: np.ndarray
    floor: np.ndarray
    solid: np.ndarray
    cell: float
    start: Pose
    radius: float
    name: str = ""
    map_origin: Pose = ORIGIN  # of the lower-left corner, in the frame of a ROS map
    occupancy: np.ndarray | None = None
    dock: Pose | None = None

    @property
    def unknown(self) -> np.ndarray:
        """(rows, columns) bool: what a ROS map says nothing about; no cell of a scene."""
        return np.zeros_like(self.solid) if self.occupancy is None else self.occupancy < 0

    def cells(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(row, column) of positions in metres; positions outside are clipped to the border."""
        rows, columns = self.visitable.shape
        row = np.floor(np.asarray(y) / self.cell).astype(np.int64)
        column = np.floor(np.asarray(x) / self.cell).astype(np.int64)
        return np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)

    def save(self, path: Path) -> None:
        numbers = {
            "cell": self.cell, "start": list(self.start), "radius": self.radius,
            "name": self.name, "map_origin": list(self.map_origin), **({"dock": list(self.dock)} if self.dock else {}),
        }
        grids = {key: getattr(self, key) for key in ("visitable", "floor", "solid", "occupancy")}
        held = {key: grid for key, grid in grids.items() if grid is not None}
        write_arrays(path, {**held, "numbers": np.array(json.dumps(numbers))})

    @classmethod
    def load(cls, path: Path) -> FloorPlan:
        arrays = read_arrays(path, ("visitable", "floor", "solid", "numbers"), ("occupancy",))
        masks, occupancy = [arrays[key] for key in ("visitable", "floor", "solid")], arrays.get("occupancy")
        with understood(path):
            numbers: dict[str, Any] = json.loads(str(arrays["numbers"]))
            poses = numbers.keys() & {"dock"} | {"start", "map_origin"}
            numbers |= {key: Pose(*map(float, numbers[key])) for key in poses}
            if {(mask.dtype, mask.ndim, mask.shape) for mask in masks} != {(np.dtype(bool), 2, masks[0].shape)}:
                raise ValueError("its masks are not alike")
            if occupancy is not None and (occupancy.dtype, occupancy.shape) != (np.dtype(np.int8), masks[0].shape):
                raise ValueError("its occupancy is not of its masks' shape")
            return cls(masks[0], masks[1], masks[2], **numbers, occupancy=occupancy)


@dataclass(frozen=True)
class Episode:
    """One life of T steps between two visits to the start.

    image (T+1, 64, 64, 3) uint8 RGB; action (T,) int64, 0 forward, 1 left, 2 right;
    pose (T+1, 3) float64, x y yaw in metres and radians; collided (T,) bool, a forward move that was
    cut short or cancelled; events: what changed in the world before it began (moved objects, light). Of a robot that
    drifts also estimate (T+1, 3), where it believed to be, and dock, how it came home before (none: the first start).
    """

    image: np.ndarray
    action: np.ndarray
    pose: np.ndarray
    collided: np.ndarray
    events: tuple[dict[str, Any], ...] = field(default=())
    estimate: np.ndarray | None = None
    dock: dict[str, Any] | None = None

    def __len__(self) -> int:
        return len(self.action)

    def every(self, repeat: int) -> Episode:
        """As one saw it who acts on every `repeat`-th frame and holds that action until the next; a rest is cut off.

        Raises RunFolderError where an action was not held.
        """
        if repeat == 1:
            return self
        action = held(self.action, repeat)
        lived = len(action) * repeat
        seen = slice(0, lived + 1, repeat)
        estimate = None if self.estimate is None else self.estimate[seen].copy()
        return replace(self, image=self.image[seen].copy(), action=action, pose=self.pose[seen].copy(),
                       estimate=estimate, collided=np.any(self.collided[:lived].reshape(-1, repeat), axis=1))

    def save(self, path: Path) -> None:
        arrays = {"image": self.image, "action": self.action, "pose": self.pose, "collided": self.collided,
                  "events": np.array(json.dumps(self.events))}
        if self.estimate is not None:
            arrays |= {"estimate": self.estimate, "dock": np.array(json.dumps(self.dock))}
        write_arrays(path, arrays)

    @classmethod
    def load(cls, path: Path) -> Episode:
        arrays = read_arrays(path, ("image", "action", "pose", "collided", "events"), ("estimate", "dock"))
        with understood(path):
            events = tuple(json.loads(str(arrays.pop("events"))))
            dock = json.loads(str(arrays.pop("dock", "null")))
        image, action = arrays["image"], arrays["action"].reshape(-1)
        shapes = [arrays[key].shape for key in ("image", "action", "pose", "collided")]
        steps = len(action)
        if shapes != [(steps + 1, *IMAGE_SHAPE), (steps,), (steps + 1, 3), (steps,)] or image.dtype != np.uint8 or \
                not np.isin(action, ACTIONS).all():
            raise RunFolderError(f"{path} holds no episode: its images are {image.dtype} {image.shape}, "
                                 f"for {len(action)} actions that should be 0, 1 or 2.")
        return cls(**arrays, events=events, dock=dock)


def held(action: np.ndarray, repeat: int, what: object = "an episode") -> np.ndarray:
    """Actions (T,) of which each was held for `repeat` steps: (T // repeat,). Raises RunFolderError for others."""
    turns = action[:len(action) // repeat * repeat].reshape(-1, repeat)
    if (turns != turns[:, :1]).any():
        raise RunFolderError(f"{what} was lived by one who did not hold its actions for {repeat} steps, as "
                             f"agent.action_repeat={repeat} needs it. Set agent.action_repeat=1.")
    return turns[:, 0].copy()


@dataclass(frozen=True)
class DockReport:
    """One homecoming. code: docked, or the name of what went wrong; human: a person carried the robot to its dock.

    attempts: approaches that were begun; recoveries: what was tried in between, by name; seconds, metres: of it all;
    distance: metres from the dock when it set out; battery: share that was left. arrival (3,): where the robot truly
    stood when the first approach began, x y yaw in the dock's frame (x away from it, yaw 0 facing it), and error (3,)
    how far off its belief was there; None where it did not come so far.
    """

    code: str
    text: str
    human: bool
    attempts: int
    recoveries: tuple[str, ...]
    seconds: float
    metres: float
    distance: float
    battery: float
    arrival: tuple[float, float, float] | None = None
    error: tuple[float, float, float] | None = None

    @property
    def success(self) -> bool:
        return self.code == "docked"

    @classmethod
    def of(cls, plain: dict[str, Any]) -> DockReport:
        """What `asdict` made, lists for tuples as JSON has them."""
        lists = {key: tuple(value) for key, value in plain.items() if isinstance(value, list)}
        return cls(**{**plain, **lists})


@dataclass(frozen=True)
class Surprise:
    """How an episode surprised an agent that had not learned from it, in M windows of L observations.

    frame (M, L) int64, of the episode; kl (M, L) float32, nats between what was expected of a frame and what
    it was; reward (M, L) float32, what the agent's curiosity expected to be paid there before seeing it.
    """

    frame: np.ndarray
    kl: np.ndarray
    reward: np.ndarray


@dataclass(frozen=True)
class Prediction:
    """What an agent expected of an episode that it had not learned from, seeing little and knowing the actions.

    W windows, drawn at F steps: step (F,) int64 counts from the last frame that the agent saw, so that 0 and
    less were seen and more were predicted; frame (W, F) int64, the frames of the episode that they stand for;
    image (W, F, 64, 64, 3) uint8, the agent's. error and repeat (N, H) float32: mean squared errors in units of
    [0, 1] after `every` to H * every steps of N windows evenly spread, the agent's and that of repeating the last
    seen frame; every: steps for which it holds an action, so that it predicts no frame in between.
    """

    step: np.ndarray
    frame: np.ndarray
    image: np.ndarray
    error: np.ndarray
    repeat: np.ndarray
    surprise: Surprise
    every: int = 1

    def metrics(self) -> dict[str, float]:
        """The mean errors after 1, 5 and 15 actions, as far as the prediction went."""
        return {f"{name}_mse_{steps}": float(error[:, steps - 1].mean(dtype=np.float64))
                for name, error in (("open_loop", self.error), ("repeat", self.repeat))
                for steps in (1, 5, 15) if steps <= error.shape[1]}

    def save(self, path: Path) -> None:
        own = {key: np.asarray(value) for key, value in vars(self).items() if key != "surprise"}
        write_arrays(path, own | {f"surprise_{key}": value for key, value in vars(self.surprise).items()})

    @classmethod
    def load(cls, path: Path) -> Prediction:
        """Raises RunFolderError where the file is broken."""
        own = read_arrays(path, ("step", "frame", "image", "error", "repeat"), ("every",))
        with understood(path):
            every = int(own.pop("every", np.array(1)))
            if every < 1:
                raise ValueError(f"an action is held for {every} steps")
        return cls(**own, surprise=cls.load_surprise(path), every=every)

    @staticmethod
    def load_surprise(path: Path) -> Surprise:
        """The surprise alone, without the images. Raises RunFolderError where the file is broken."""
        keys = ("frame", "kl", "reward")
        arrays = read_arrays(path, tuple(f"surprise_{key}" for key in keys))
        return Surprise(*(arrays[f"surprise_{key}"] for key in keys))
