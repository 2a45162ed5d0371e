"""An episode as a bag: images, depth, odometry, actions, transforms and a map, at a steady rate.

Frame t is written at start + t / rate. The action that was chosen on it has its time, so that whoever pairs each image
with the newest action gets (observation, action); the state tells whether the step that led to it collided.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from curionav_cli.bags import messages, ours
from curionav_cli.bags.source import COMPRESSED, Source
from curionav_cli.bags.writer import BagWriter
from curionav_cli.geometry import wrapped
from curionav_cli.records import ORIGIN, Episode, Pose

DAY = 86_400 * 10**9  # nanoseconds; episode k begins on day k after SINCE
SINCE = 10**18  # 2001-09-09, so that no viewer takes a time for missing
DEPTH = "/depth/image_raw"  # of a profile without a depth camera
LATCHED = (ours.TF_STATIC, ours.MAP, ours.EPISODE)
STATE = "x m, y m, yaw rad, collided"
CHOICES = "0 forward, 1 left, 2 right"


class Map(NamedTuple):
    """cells (rows, columns) int8, -1 unknown, 0 free to 100 occupied, row 0 the lowest; cell: metres; corner: of row 0,
    column 0, in the frame: map, or odom where a robot that drifts made it."""

    cells: np.ndarray
    cell: float
    corner: Pose
    frame: str = "map"


@dataclass(frozen=True)
class Form:
    """How bags are written. source: whose topics; packed: images as PNG instead of raw; rate: steps a second; camera:
    its height in metres."""

    source: Source
    packed: bool
    rate: float
    camera: float

    @property
    def image(self) -> str:
        """The topic of the images, which by custom ends in /compressed where they are."""
        plain = self.source.image.removesuffix(COMPRESSED)
        return plain + COMPRESSED * self.packed

    @property
    def depth(self) -> str:
        """The topic of the depth images."""
        return self.source.depth or DEPTH


def write(folder: Path, episode: Episode, number: int, form: Form, depth: np.ndarray | None, grid: Map | None,
          about: dict[str, Any]) -> None:
    """Write a bag at `folder`, whole or absent. number: of the episode; depth (T+1, 64, 64) float32 metres.

    about: what else EPISODE says, such as the run's settings. Raises OSError.
    """
    start = SINCE + number * DAY
    with BagWriter(folder, LATCHED) as bag:
        told = {ours.MARK: ours.LAYOUT, "image": form.image, "episode": number, "steps": len(episode),
                "events": list(episode.events), **({} if episode.estimate is None else {"dock": episode.dock}),
                **({} if depth is None else {"depth": form.depth}), **about}
        bag.write(ours.EPISODE, start, messages.text(json.dumps(told)))
        bag.write(ours.TF_STATIC, start, messages.transforms(messages.camera(form.camera, start)))
        if grid is not None:
            bag.write(ours.MAP, start, messages.grid(*grid, start))
        for frame in range(len(episode) + 1):
            at = start + round(1e9 * frame / form.rate)
            for topic, message in frame_messages(episode, frame, form, depth, at):
                bag.write(topic, at, message)


def frame_messages(episode: Episode, frame: int, form: Form, depth: np.ndarray | None,
                   at: int) -> Iterator[tuple[str, Any]]:
    """Yield the messages of a frame with their topics."""
    picture = messages.png if form.packed else messages.raw
    yield form.image, picture(episode.image[frame], at)
    if depth is not None:
        yield form.depth, messages.raw(depth[frame], at)
    yield from motion(episode, frame, form, at)
    collided = float(frame > 0 and episode.collided[frame - 1])
    yield ours.STATE, messages.numbers(STATE, *episode.pose[frame], collided)
    if episode.estimate is not None:
        yield ours.ESTIMATE, messages.numbers("x m, y m, yaw rad", *episode.estimate[frame])
    if frame < len(episode):
        yield ours.ACTION, messages.numbers(CHOICES, float(episode.action[frame]))


def motion(episode: Episode, frame: int, form: Form, at: int) -> Iterator[tuple[str, Any]]:
    """Yield odometry and transforms: odom is the robot's estimate where it has one, and map the true frame."""
    along = episode.pose if episode.estimate is None else episode.estimate
    here, before = Pose(*along[frame]), Pose(*along[max(frame - 1, 0)])
    turn = wrapped(here.yaw - before.yaw)
    heading = before.yaw + 0.5 * turn
    ahead = (here.x - before.x) * math.cos(heading) + (here.y - before.y) * math.sin(heading)
    yield form.source.odom, messages.odometry(here, ahead * form.rate, turn * form.rate, at)
    drift = ORIGIN if episode.estimate is None else correction(Pose(*episode.pose[frame]), here)
    yield ours.TF, messages.transforms(messages.planar("map", "odom", drift, at),
                                       messages.planar("odom", "base_link", here, at))


def correction(true: Pose, estimate: Pose) -> Pose:
    """Where the frame of the estimate stands on the map, if the robot stands at the true pose."""
    yaw = true.yaw - estimate.yaw
    cosine, sine = math.cos(yaw), math.sin(yaw)
    return Pose(true.x - cosine * estimate.x + sine * estimate.y, true.y - sine * estimate.x - cosine * estimate.y, yaw)
