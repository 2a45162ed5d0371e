"""An episode as a film: the robot's camera beside its path on the floor plan.

VP8 in WebM, which opencv-python-headless writes and every browser plays; the same bytes when made again.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from matplotlib.colors import to_rgb

from curionav_cli.errors import RunFolderError
from curionav_cli.files import write_bytes
from curionav_cli.records import Episode, FloorPlan
from curionav_cli.results.floor_plans import START, picture_of

SIDE = 192  # pixels: the camera's picture is enlarged three times
FRAMES_A_SECOND = 20  # steps
VP8 = int.from_bytes(b"VP80", "little")
INK, PATH, ROBOT = (17, 24, 39), (11, 95, 165), (194, 65, 12)
FINE = 8  # of OpenCV's fractions of a pixel, in bits
TRACK = b"\x73\xc5\x88"  # Matroska's TrackUID, eight random bytes behind it


def frames(plan: FloorPlan, episode: Episode, name: str, every: int = 1) -> Iterator[np.ndarray]:
    """Draw (SIDE, any even, 3) uint8 RGB for every n-th of T+1 poses, beginning with the first."""
    view = PlanView(plan)
    for step, (image, pose) in enumerate(zip(episode.image, episode.pose, strict=True)):
        above = view.at(pose)
        if step % every:
            continue
        seen = cv2.resize(image, (SIDE, SIDE), interpolation=cv2.INTER_LINEAR)
        seen[-20:] = INK
        cv2.putText(seen, f"{name}, step {step} of {len(episode)}", (6, SIDE - 6), cv2.FONT_HERSHEY_SIMPLEX, 0.36,
                    (255, 255, 255), 1, cv2.LINE_AA)
        yield np.concatenate([seen, above], axis=1)


class PlanView:
    """The floor plan from above, with the path so far."""

    def __init__(self, plan: FloorPlan):
        used = np.argwhere(plan.floor)
        low, high = np.maximum(used.min(0) - 2, 0), used.max(0) + 3
        picture = (255 * picture_of(plan)[low[0]:high[0], low[1]:high[1]]).astype(np.uint8)
        rows, columns = picture.shape[:2]
        self.scale = min(SIDE / rows, 2 * SIDE / columns)  # pixels a cell
        size = round(columns * self.scale) // 2 * 2, round(rows * self.scale) // 2 * 2
        self.drawn = np.full((SIDE, size[0], 3), 255, np.uint8)
        fewer = cv2.INTER_AREA if self.scale < 1 else cv2.INTER_NEAREST  # no thin wall of a large building gets lost
        self.drawn[:size[1]] = cv2.resize(picture, size, interpolation=fewer)[::-1]
        self.plan, self.low, self.height = plan, low, size[1]
        self.last: tuple[int, int] | None = None
        middle, half = np.array(self.pixel(plan.start.x, plan.start.y)) >> FINE, max(4, round(self.scale))
        blue = tuple(round(255 * part) for part in to_rgb(START[1]))
        cv2.rectangle(self.drawn, (middle - half).tolist(), (middle + half).tolist(), blue, -1)

    def pixel(self, x: float, y: float) -> tuple[int, int]:
        """Pixel of a place in metres, in OpenCV's fractions."""
        across = (x / self.plan.cell - self.low[1]) * self.scale
        down = self.height - (y / self.plan.cell - self.low[0]) * self.scale
        return round(across * 2 ** FINE), round(down * 2 ** FINE)

    def at(self, pose: np.ndarray) -> np.ndarray:
        """Draw the plan with the robot at this pose (3,), metres and radians; (SIDE, width, 3) uint8 RGB."""
        here = self.pixel(pose[0], pose[1])
        cv2.line(self.drawn, self.last or here, here, PATH, 2, cv2.LINE_AA, FINE)
        self.last = here
        shown, radius = self.drawn.copy(), self.plan.radius
        ahead = self.pixel(pose[0] + 2 * radius * np.cos(pose[2]), pose[1] + 2 * radius * np.sin(pose[2]))
        size = round(radius / self.plan.cell * self.scale * 2 ** FINE)
        cv2.circle(shown, here, size, ROBOT, -1, cv2.LINE_AA, FINE)
        cv2.line(shown, here, ahead, INK, 2, cv2.LINE_AA, FINE)
        return shown


def write(pictures: Iterable[np.ndarray], path: Path) -> None:
    """Write pictures (H, W, 3) uint8 RGB as .webm, finished or absent. Raises RunFolderError without an encoder."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "film.webm"
        encode(pictures, file)
        film = file.read_bytes()
    write_bytes(path, with_fixed_track(film))


def encode(pictures: Iterable[np.ndarray], file: Path) -> None:
    writer: cv2.VideoWriter | None = None
    for picture in pictures:
        if writer is None:
            with quiet():
                writer = cv2.VideoWriter(str(file), VP8, FRAMES_A_SECOND, picture.shape[1::-1])
            if not writer.isOpened():
                raise RunFolderError("This OpenCV cannot write VP8, so there is no film. The wheel "
                                     "opencv-python-headless can.")
        writer.write(np.ascontiguousarray(picture[..., ::-1]))
    if writer is not None:
        writer.release()


@contextmanager
def quiet() -> Iterator[None]:
    """Hide what OpenCV prints on stderr: that WebM has no four letters for VP8, which it writes all the same."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    try:
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)


def with_fixed_track(film: bytes) -> bytes:
    """Replace the random number of the film's only track by 1."""
    at = film.index(TRACK) + len(TRACK)
    return film.replace(film[at:at + 8], (1).to_bytes(8, "big"))
