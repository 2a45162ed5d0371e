"""Records that layers exchange: Pose, FloorPlan, Episode, DockReport, Surprise, Prediction, with their files.

Frames. x points right and y up, in metres from the lower-left corner of the scene (for a ROS map: of its image, or of
the part of it that a large map is cropped to); yaw is counter-clockwise from +x in radians. Cell (row, column) covers
[column, column + 1) * cell in x and [row, row + 1) * cell in y, so row 0 is the lowest.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from curionav_cli.constants import ACTIONS, IMAGE_SHAPE
from curionav_cli.decisions import Decisions, Every
from curionav_cli.errors import RunFolderError
from curionav_cli.files import FAST, SMALL, read_arrays, understood, write_arrays


class Pose(NamedTuple):
    """Position in metres and yaw in radians; the module's docstring defines the frame."""

    x: float
    y: float
    yaw: float


ORIGIN = Pose(0.0, 0.0, 0.0)
PLAN_ARRAYS, PLAN_OPTIONAL = ("visitable", "floor", "solid", "numbers"), ("occupancy", "picture")  # of a floor plan
GONE = "{} holds {} of its {} images: the run did not keep the others. Record one with loop.keep=all."


@dataclass(frozen=True)
class FloorPlan:
    """The grid of a scene that a run folder keeps: enough to count coverage and to draw it.

    visitable, floor, solid (rows, columns) bool: cells whose centre the robot can reach; every cell of the building;
    cells covered by a wall or furniture. cell: side of a cell, radius: of the robot, metres.
    occupancy (rows, columns) int8: of a ROS map, -1 unknown, 0 free to 100 occupied; None of a scene.
    start: where episodes begin; dock: None where the robot starts at its dock. bounded: False of a real floor without
    a map, where the cells are a frame to count in, and how many can be visited is not known. picture (any, any, 3)
    uint8: of a scan, all cells from above, row 0 the lowest.
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
    bounded: bool = True
    picture: np.ndarray | None = None

    def total(self, denominator: str = "visitable") -> int | None:
        """The number of cells of a denominator, visitable or floor; None where it is not known."""
        return int(getattr(self, denominator).sum()) if self.bounded else None

    @property
    def unknown(self) -> np.ndarray:
        """Cells that a ROS map marks as unknown, (rows, columns) bool; none of a scene."""
        return np.zeros_like(self.solid) if self.occupancy is None else self.occupancy < 0

    def cells(self, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(row, column), int64 arrays, of positions in metres; positions outside are clipped to the border."""
        rows, columns = self.visitable.shape
        row = np.floor(np.asarray(y) / self.cell).astype(np.int64)
        column = np.floor(np.asarray(x) / self.cell).astype(np.int64)
        return np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)

    def away(self, place: Pose) -> np.ndarray:
        """Distance (rows, columns) of the centre of every cell from a place, metres as the crow flies."""
        row, column = np.indices(self.visitable.shape)
        return np.hypot((column + 0.5) * self.cell - place.x, (row + 0.5) * self.cell - place.y)

    def arrays(self) -> dict[str, np.ndarray]:
        """The plan as arrays, from which `of` makes it again."""
        numbers = {
            "cell": self.cell, "start": list(self.start), "radius": self.radius,
            "name": self.name, "map_origin": list(self.map_origin), **({"dock": list(self.dock)} if self.dock else {}),
            **({} if self.bounded else {"bounded": False}),
        }
        grids = {key: getattr(self, key) for key in (*PLAN_ARRAYS[:3], *PLAN_OPTIONAL)}
        held = {key: grid for key, grid in grids.items() if grid is not None}
        return {**held, "numbers": np.array(json.dumps(numbers))}

    @classmethod
    def of(cls, arrays: dict[str, np.ndarray]) -> FloorPlan:
        """The plan of these arrays. Raises ValueError, TypeError or KeyError where they are none of a plan."""
        masks, occupancy = [arrays[key] for key in PLAN_ARRAYS[:3]], arrays.get("occupancy")
        picture = arrays.get("picture")
        numbers: dict[str, Any] = json.loads(str(arrays["numbers"]))
        poses = numbers.keys() & {"dock"} | {"start", "map_origin"}
        numbers |= {key: Pose(*map(float, numbers[key])) for key in poses}
        if {(mask.dtype, mask.ndim, mask.shape) for mask in masks} != {(np.dtype(bool), 2, masks[0].shape)}:
            raise ValueError("its masks are not alike")
        if occupancy is not None and (occupancy.dtype, occupancy.shape) != (np.dtype(np.int8), masks[0].shape):
            raise ValueError("its occupancy is not of its masks' shape")
        if picture is not None and (picture.dtype, picture.ndim, picture.shape[-1]) != (np.dtype(np.uint8), 3, 3):
            raise ValueError("its picture is none")
        return cls(masks[0], masks[1], masks[2], **numbers, occupancy=occupancy, picture=picture)

    def save(self, path: Path) -> None:
        """Write the plan as npz, whole or absent."""
        write_arrays(path, self.arrays())

    @classmethod
    def load(cls, path: Path) -> FloorPlan:
        """Read what `save` wrote. Raises RunFolderError where the file is broken."""
        arrays = read_arrays(path, PLAN_ARRAYS, PLAN_OPTIONAL)
        with understood(path):
            return cls.of(arrays)


@dataclass(frozen=True)
class Episode:
    """An episode of T steps, from a reset to the next.

    image (T+1, 64, 64, 3) uint8 RGB; action (T,) int64, 0 forward, 1 left, 2 right; pose (T+1, 3) float64, the true
    x y yaw in metres and radians; collided (T,) bool, forward moves that were cut short or cancelled; events: what
    changed in the world before the episode (moved objects, light). With odometry drift also estimate (T+1, 3), the
    estimated x y yaw, and dock, the return to dock before the episode as a dictionary of DockReport (None before the
    first). kept (K,) int64, rising: where the run did not keep all images (loop.keep), the frames of those in `image`.
    Of a bag also depth (T+1, 64, 64) float32, metres along the optical axis, where the bag has it; nothing that learns
    uses it, so that `load` leaves it out unless it is asked for.
    """

    image: np.ndarray
    action: np.ndarray
    pose: np.ndarray
    collided: np.ndarray
    events: tuple[dict[str, Any], ...] = field(default=())
    estimate: np.ndarray | None = None
    dock: dict[str, Any] | None = None
    kept: np.ndarray | None = None
    depth: np.ndarray | None = None

    def __len__(self) -> int:
        return len(self.action)

    def images(self, frame: np.ndarray, what: object = "the episode") -> np.ndarray:
        """Images (n, 64, 64, 3) of these frames (n,). Raises RunFolderError, which names `what`, for one not kept."""
        if self.kept is None:
            return self.image[frame]
        if not np.isin(frame, self.kept).all():
            raise RunFolderError(GONE.format(what, len(self.kept), len(self) + 1))
        return self.image[np.searchsorted(self.kept, frame)]

    def every(self, every: Every) -> Episode:
        """The episode at the frames at which its agent chose. Raises RunFolderError as `Every.decisions` does."""
        return self.at(every.decisions(self.action, self.collided))

    def at(self, kept: Decisions, what: object = "the episode") -> Episode:
        """The episode at these frames, with what was chosen as its actions; what was cut off at its end is left out.

        Raises RunFolderError, which names `what`, where images of these frames were not kept.
        """
        if len(kept.action) == len(self) and self.kept is None:  # a choice of one step is its primitive action
            return self
        frame = kept.frame
        estimate, depth = (None if array is None else array[frame] for array in (self.estimate, self.depth))
        collided = np.array([self.collided[first:end].any() for first, end in pairwise(frame)], bool)
        return replace(self, image=self.images(frame, what), action=kept.action, pose=self.pose[frame],
                       estimate=estimate, collided=collided, depth=depth, kept=None)

    def save(self, path: Path) -> None:
        """Write the episode as npz, whole or absent; same bytes for the same episode."""
        images = {"image": self.image} if self.kept is None else {"kept": self.kept, "kept_image": self.image}
        arrays = {**images, "action": self.action, "pose": self.pose, "collided": self.collided,
                  "events": np.array(json.dumps(self.events))}
        if self.estimate is not None:
            arrays |= {"estimate": self.estimate, "dock": np.array(json.dumps(self.dock))}
        if self.depth is not None:
            arrays["depth"] = self.depth
        write_arrays(path, arrays, FAST if self.kept is None else SMALL)

    @classmethod
    def load(cls, path: Path, thinned: bool = False, depth: bool = False) -> Episode:
        """Read what `save` wrote. thinned: also one of which not all images are kept; depth: it too, where it is there.

        Raises RunFolderError where the file is broken, the shapes do not fit, or images are gone.
        """
        arrays = read_arrays(path, ("action", "pose", "collided", "events"),
                             ("image", "kept", "kept_image", "estimate", "dock", *(["depth"] if depth else [])))
        with understood(path):
            events = tuple(json.loads(str(arrays.pop("events"))))
            dock = json.loads(str(arrays.pop("dock", "null")))
            if "kept" in arrays:
                arrays["image"] = arrays.pop("kept_image")
            episode = cls(**arrays, events=events, dock=dock)
        refuse_misshapen(episode, path)
        if episode.kept is not None and not thinned:
            raise RunFolderError(GONE.format(path, len(episode.kept), len(episode) + 1))
        return episode


def refuse_misshapen(episode: Episode, path: Path) -> None:
    """Raises RunFolderError where the arrays read from `path` do not fit together."""
    image, action, kept = episode.image, episode.action.reshape(-1), episode.kept
    steps = len(action)
    held = steps + 1 if kept is None else kept.size
    shapes = [array.shape for array in (image, episode.action, episode.pose, episode.collided)]
    if shapes != [(held, *IMAGE_SHAPE), (steps,), (steps + 1, 3), (steps,)] or image.dtype != np.uint8 or \
            not np.isin(action, ACTIONS).all():
        raise RunFolderError(f"{path} holds no episode: its images are {image.dtype} {image.shape}, "
                             f"for {steps} actions that should be 0, 1 or 2.")
    if kept is not None and not (kept.dtype == np.int64 and kept.ndim == 1 and
                                 (np.diff([-1, *kept, steps + 1]) > 0).all()):
        raise RunFolderError(f"{path} holds no episode: its `kept` does not rise from 0 to {steps}.")
    depth = episode.depth
    if depth is not None and (depth.dtype, depth.shape) != (np.float32, image.shape[:3]):
        raise RunFolderError(f"{path} holds depth of {depth.dtype} {depth.shape}, for {len(image)} images.")


@dataclass(frozen=True)
class DockReport:
    """A return to dock. code: docked, or the name of the failure; human: a person carried the robot to its dock.

    attempts: approaches that were begun; recoveries: what was tried in between, by name; seconds, metres: in total;
    distance: metres to the dock at the beginning; battery: share of charge that was left. arrival (3,): true pose at
    the beginning of the first approach, x y yaw in the dock's frame (x away from it, yaw 0 facing it), and error (3,)
    of the estimate there, metres and radians; None where no approach was begun.
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
        """Whether the robot docked by itself."""
        return self.code == "docked"

    @classmethod
    def of(cls, plain: dict[str, Any]) -> DockReport:
        """The report that `asdict` turned into a dictionary, with lists for tuples as JSON has them."""
        lists = {key: tuple(value) for key, value in plain.items() if isinstance(value, list)}
        return cls(**{**plain, **lists})


@dataclass(frozen=True)
class Surprise:
    """Surprise and predicted reward of an agent on an episode before it learned from it, in M windows of L frames.

    frame (M, L) int64, indices in the episode; kl (M, L) float32, nats between the posterior and the prior of a frame;
    reward (M, L) float32, intrinsic reward predicted for a frame before it is observed.
    """

    frame: np.ndarray
    kl: np.ndarray
    reward: np.ndarray


def counted(every: int) -> str:
    """What predictions with this `every` count."""
    return "steps" if every else "options"


@dataclass(frozen=True)
class Prediction:
    """Open-loop predictions of an agent for an episode that it has not learned from.

    The agent observes a few frames of context, then the actions alone. W windows, drawn at F steps: step (F,) int64
    counts from the last frame of the context, so that steps up to 0 are reconstructed and later ones predicted;
    frame (W, F) int64, their indices in the episode; image (W, F, 64, 64, 3) uint8, the agent's, or (0, F, 64, 64, 3)
    where the run did not keep them (loop.keep). error and repeat
    (N, H) float32: mean squared errors, of images in [0, 1], after `every` to H * every steps of N windows evenly
    spread, of the agent and of repeating the last frame of the context. every: steps for which an action is held; no
    frame in between is predicted. 0: actions of different lengths (options), and `step` and H count these.
    """

    step: np.ndarray
    frame: np.ndarray
    image: np.ndarray
    error: np.ndarray
    repeat: np.ndarray
    surprise: Surprise
    every: int = 1

    def metrics(self) -> dict[str, float]:
        """Mean errors after 1, 5 and 15 actions, as far as the prediction goes, for metrics.jsonl."""
        return {f"{name}_mse_{steps}": float(error[:, steps - 1].mean(dtype=np.float64))
                for name, error in (("open_loop", self.error), ("repeat", self.repeat))
                for steps in (1, 5, 15) if steps <= error.shape[1]}

    def save(self, path: Path) -> None:
        """Write the prediction as npz, whole or absent."""
        left_out = {"surprise"} if len(self.image) else {"surprise", "image"}
        own = {key: np.asarray(value) for key, value in vars(self).items() if key not in left_out}
        write_arrays(path, own | {f"surprise_{key}": value for key, value in vars(self.surprise).items()})

    @classmethod
    def load(cls, path: Path) -> Prediction:
        """Read what `save` wrote. Raises RunFolderError where the file is broken."""
        own = read_arrays(path, ("step", "frame", "error", "repeat"), ("image", "every"))
        with understood(path):
            own.setdefault("image", np.zeros((0, own["step"].size, *IMAGE_SHAPE), np.uint8))
            every = int(own.pop("every", np.array(1)))
            if every < 0:
                raise ValueError(f"an action is held for {every} steps")
        return cls(**own, surprise=cls.load_surprise(path), every=every)

    @staticmethod
    def load_surprise(path: Path) -> Surprise:
        """Read the surprise alone, without the images. Raises RunFolderError where the file is broken."""
        keys = ("frame", "kl", "reward")
        arrays = read_arrays(path, tuple(f"surprise_{key}" for key in keys))
        return Surprise(*(arrays[f"surprise_{key}"] for key in keys))
