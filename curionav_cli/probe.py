"""A fixed probe of a building, and what a world model makes of it: the measure of what an explorer taught its model.

A probe is privileged: its poses are drawn from the true map. It is for evaluation only, and no agent learns from it.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from curionav_cli.constants import FORWARD, IMAGE_SHAPE, STEP_LENGTH
from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_arrays, write_arrays

CONTEXT = 5  # frames of a sequence that a model observes before it predicts open-loop


@dataclass(frozen=True)
class Probe:
    """N sequences of T actions through a building.

    image (N, T+1, 64, 64, 3) uint8 RGB; action (N, T) int64: 0 forward, 1 left, 2 right, each held for `every` steps of
    the robot, or options (options.py) where `every` is 0; pose (N, T+1, 3) float64, x y yaw in metres and radians.
    """

    image: np.ndarray
    action: np.ndarray
    pose: np.ndarray
    every: int

    def __len__(self) -> int:
        return len(self.action)

    @cached_property
    def free(self) -> np.ndarray:
        """(N, H) bool: the frames after the context that no blocked forward move since then has led to.

        All are where the actions are options: to drive until something is in the way is one.
        """
        if not self.every:
            return np.ones((len(self), self.action.shape[1] + 1 - CONTEXT), bool)
        driven = np.hypot(*np.moveaxis(np.diff(self.pose[:, CONTEXT - 1:, :2], axis=1), -1, 0))
        blocked = (self.action[:, CONTEXT - 1:] == FORWARD) & (driven < self.every * STEP_LENGTH - 1e-6)
        return ~np.logical_or.accumulate(blocked, axis=1)

    @cached_property
    def checksum(self) -> str:
        """A checksum of images and actions: equal where two runs were measured on the same probe."""
        return f"{zlib.crc32(self.action.tobytes(), zlib.crc32(self.image.tobytes())):08x}"

    def save(self, path: Path) -> None:
        """Write the probe as npz, whole or absent; same bytes for the same probe."""
        write_arrays(path, {key: np.asarray(getattr(self, key)) for key in ("image", "action", "pose", "every")})

    @classmethod
    def load(cls, path: Path) -> Probe:
        """Read what `save` wrote. Raises RunFolderError where the file is broken or the shapes do not fit."""
        arrays = read_arrays(path, ("image", "action", "pose", "every"))
        image, action, pose = arrays["image"], arrays["action"], arrays["pose"]
        frames = (len(action), action.shape[-1] + 1) if action.ndim == 2 else ()
        if (image.shape, pose.shape) != ((*frames, *IMAGE_SHAPE), (*frames, 3)) or image.dtype != np.uint8:
            raise RunFolderError(f"{path} holds no probe: its images are {image.dtype} {image.shape}.")
        return cls(image, action, pose, int(arrays["every"]))


@dataclass(frozen=True)
class Probed:
    """A world model's errors and surprise on a probe, at the H frames of each sequence after the context: (N, H) each.

    With x the image of a frame in [0, 1], x' the image predicted for it open-loop (from the context and the actions
    alone), and q and p the posterior and the prior of its latents where every frame before it was observed:

        error     mean over pixels and colours of (x' - x)^2
        repeat    the same with the last frame of the context for x'; it depends on the probe alone
        surprise  KL[q || p] in nats, summed over the latents

    free: the frames that no blocked move led to (Probe.free). An explorer that avoids walls teaches little about them.
    """

    error: np.ndarray
    repeat: np.ndarray
    surprise: np.ndarray
    free: np.ndarray

    def metrics(self) -> dict[str, float]:
        """Means for metrics.jsonl: of each over all sequences and frames, and of the error over the free frames."""
        of = {**vars(self), "error_free": self.error[self.free]}
        del of["free"]
        return {f"probe_{key}": float(values.mean(dtype=np.float64)) for key, values in of.items() if values.size}
