"""The frames of a replay on the learner's device: on a GPU as uint8, 12 kB each, where batches are gathered.

Episodes that do not fit stay on the host; windows drawn from them are copied through two buffers in page-locked memory,
of which one is filled while the other is sent.

Letters: B windows of L frames, M of them on the host.
"""

from __future__ import annotations

import logging
import math

import numpy as np
import torch
from torch import Tensor

from curionav_cli.constants import IMAGE_SHAPE
from curionav_cli.storage.replay import Replay

SHARE = 0.5  # of the GPU's free memory; the rest is for activations
FRAME = math.prod(IMAGE_SHAPE)

log = logging.getLogger("curionav")


def room_on(device: torch.device) -> int:
    """Bytes that frames may take on the device; 0 for a CPU, where they already are."""
    return int(SHARE * torch.cuda.mem_get_info(device)[0]) if device.type == "cuda" else 0


class DeviceReplay:
    """Holds the first episodes of `replay` that fit into `room` bytes on `device`, and copies windows of the others.

    episodes: index -> frames (steps + 1, FRAME). next: the first episode that was not looked at yet.
    """

    def __init__(self, replay: Replay, device: torch.device, room: int):
        self.replay, self.device, self.room = replay, device, room
        self.full, self.next = not room, 0
        self.episodes: dict[int, Tensor] = {}
        self.buffers: list[Tensor] = []  # (B, L, FRAME) each, page-locked for a GPU
        self.sent: list[torch.cuda.Event] = []  # the last copy from each buffer
        self.turn = 0

    def follow(self) -> None:
        """Copy the episodes that are new in the replay, and let go of those that it does not hold any more."""
        for index in [index for index in self.episodes if index < self.replay.dropped]:
            self.room += self.episodes.pop(index).nbytes
            self.full = False
        self.next = max(self.next, self.replay.dropped)
        while not self.full and self.next < len(self.replay):
            image = self.replay.episode(self.next).image
            self.full = image.nbytes > self.room
            if not self.full:
                self.episodes[self.next] = torch.from_numpy(image).flatten(1).to(self.device)
                self.room, self.next = self.room - image.nbytes, self.next + 1
            elif not self.replay.dropped:
                log.warning("The GPU holds the first %d episodes; frames of later ones are sent for every update, "
                            "which is slower.", len(self.episodes))

    def windows(self, which: np.ndarray, start: np.ndarray, length: int) -> Tensor:
        """Frames (L, B, 64, 64, 3) uint8 of the windows that `replay.draw` returned: which (B,), start (B,)."""
        on_host = np.array([episode not in self.episodes for episode in which.tolist()])
        sent = iter(self._send(which[on_host], start[on_host], (len(which), length, FRAME)) if on_host.any() else ())
        rows = [self.episodes[e][s:s + length] if e in self.episodes else next(sent)
                for e, s in zip(which.tolist(), start.tolist(), strict=True)]
        return torch.stack(rows, 1).view(length, len(rows), *IMAGE_SHAPE)

    def _send(self, which: np.ndarray, start: np.ndarray, most: tuple[int, int, int]) -> Tensor:
        """Copy windows (M, L, FRAME) from the host; `most`: the largest such shape."""
        cuda = self.device.type == "cuda"
        if not self.buffers:
            self.buffers = [torch.empty(most, dtype=torch.uint8, pin_memory=cuda) for _ in range(2)]
            self.sent = [torch.cuda.Event() for _ in range(2)] if cuda else []
        self.turn = 1 - self.turn
        frames = self.buffers[self.turn][:len(which)]
        if cuda:
            self.sent[self.turn].synchronize()  # of the batch before the last: the GPU is not waited for
        self.replay.frames(which, start, frames.view(*frames.shape[:2], *IMAGE_SHAPE).numpy())
        on_device = frames.to(self.device, non_blocking=True)
        if cuda:
            self.sent[self.turn].record()
        return on_device
