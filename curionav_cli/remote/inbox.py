"""The server's inbox: marked episodes, each verified here, each once, in the order of their numbers.

A number that is missing or arrived broken is waited for, so that the weights are those of a run without faults.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from curionav_cli.constants import IMAGE_SHAPE
from curionav_cli.decisions import EACH_STEP, Every
from curionav_cli.errors import EpisodeRefused, RunFolderError
from curionav_cli.files import opened, write_bytes
from curionav_cli.records import Episode
from curionav_cli.remote.ledger import Ledger
from curionav_cli.remote.object_store import ObjectStore
from curionav_cli.remote.protocol import MARKED, SMALL, Marker, Refusal, parsed, sha256, written

MEMBERS = {f"{name}.npy" for name in ("image", "action", "pose", "collided", "events")}
ESTIMATE = {"estimate.npy", "dock.npy"}  # of a robot with odometry drift
TEXTS = ("events.npy", "dock.npy")
TEXT_BYTES = 1 << 20  # at most, of an episode
STEP = math.prod(IMAGE_SHAPE) + 128  # bytes of a step
LONGEST = 60.0  # seconds until a refused episode is fetched again


class Arrival(NamedTuple):
    """A verified episode and its marker."""

    marker: Marker
    episode: Episode


class Inbox:
    """Episodes of a storage that are not yet learned from.

    folder: the quarantine, where broken episodes are kept, the newest of each name. settings: the fingerprint that
    markers must carry. steps: of the longest episode. gap: seconds that a missing number is waited for. clock: the
    time in seconds. say: prints a line. every: how often the robot's agent chooses.
    """

    def __init__(self, store: ObjectStore, ledger: Ledger, folder: Path, *, settings: str, steps: int, gap: float,
                 clock: Callable[[], float], say: Callable[[str], None], every: Every = EACH_STEP):
        self.store, self.ledger, self.folder, self.settings, self.steps = store, ledger, folder, settings, steps
        self.gap, self.clock, self.say, self.every = gap, clock, say, every
        self.first: list[str] = []  # taken before an interruption: these come first again
        self.retry_at: dict[str, float] = {}  # the time at which a refused episode is fetched again
        self.missing_since: float | None = None

    def next(self) -> Arrival | None:
        """The next episode to learn from; None where there is none now. Raises Unreachable."""
        taken = self.ledger.names()
        marked = [name.removesuffix(".json") for name in self.store.names("episodes", MARKED)]
        for name in [name for name in self.first if name in marked] + marked:
            if name in taken or self.clock() < self.retry_at.get(name, float("-inf")):
                continue
            seq, due = int(name.partition("-")[0]), self.ledger.newest() + 1
            if seq > due and name not in self.first and not self.waited(due, seq):
                return None
            try:
                arrival = self.fetch(name)
            except EpisodeRefused as error:
                self.refuse(name, str(error))
                continue
            self.missing_since = None
            self.accept(arrival.marker)
            return arrival
        return None

    def waited(self, due: int, seq: int) -> bool:
        """Whether number `due` was waited for long enough to go on with `seq`."""
        now = self.clock()
        if self.missing_since is None:
            self.missing_since = now
            if self.gap:
                self.say(f"episode {seq} is here and {due} is not: waits up to {self.gap:g} s for it")
        if now - self.missing_since < self.gap:
            return False
        self.say(f"episode {due} did not come: goes on with {seq}")
        return True

    def fetch(self, name: str) -> Arrival:
        """Read and verify an episode. Raises EpisodeRefused where it is broken, missing or not as its marker states."""
        try:
            marker = parsed(Marker, self.store.get(f"episodes/{name}.json", SMALL) or b"")
            self.check(marker, name)
            raw = self.store.get(f"episodes/{name}.npz", marker.size)
            if raw is None:
                raise ValueError("there is a marker and no episode")
            if len(raw) != marker.size or sha256(raw) != marker.sha256:
                self.quarantine(name, raw)
                raise ValueError(f"its {len(raw)} bytes are not the {marker.size} that its marker states")
            return Arrival(marker, self.unpacked(name, raw, marker))
        except (ValueError, TypeError, RunFolderError) as error:
            raise EpisodeRefused(str(error)) from error

    def check(self, marker: Marker, name: str) -> None:
        """Raises ValueError for a marker of another episode, other settings, or an impossible size."""
        if marker.name != name:
            raise ValueError("its marker names another episode")
        if marker.settings != self.settings:
            raise ValueError("it was recorded with other settings")
        if not 1 <= marker.steps <= self.steps or marker.size > most_bytes(self.steps):
            raise ValueError(f"{marker.steps} steps in {marker.size} bytes cannot be")

    def unpacked(self, name: str, raw: bytes, marker: Marker) -> Episode:
        """The episode in an archive. Raises ValueError, before unpacking, where it cannot be one of that length."""
        self.folder.mkdir(exist_ok=True)
        refuse_bombs(raw)
        path = self.quarantine(name, raw)
        with opened(path) as archive:
            sizes = {info.filename: info.file_size for info in archive.infolist()}
        if sizes.keys() not in (MEMBERS, MEMBERS | ESTIMATE) or sum(sizes.values()) > most_bytes(marker.steps) or \
                sum(sizes.get(name, 0) for name in TEXTS) > TEXT_BYTES:
            raise ValueError("it does not hold what an episode holds")
        episode = Episode.load(path)
        refuse_wrong_arrays(episode, marker.steps)
        self.every.decisions(episode.action, episode.collided, "it")
        path.unlink()
        return episode

    def quarantine(self, name: str, raw: bytes) -> Path:
        """Keep an archive that is not verified yet; its path."""
        self.folder.mkdir(exist_ok=True)
        path = self.folder / f"{name}.npz"
        write_bytes(path, raw)
        return path

    def refuse(self, name: str, reason: str) -> None:
        """Note a refusal, in the storage too, where the robot finds it and sends the episode again."""
        plain = reason.encode("ascii", "replace").decode()[:200]
        times = self.ledger.refuse(name, plain)
        self.retry_at[name] = self.clock() + min(LONGEST, 2.0 ** min(times, 10))
        if times == 1:
            self.say(f"episode {name} is refused: {plain}")
        self.store.put(f"refused/{name}.json", written(Refusal(times, plain)))

    def accept(self, marker: Marker) -> None:
        """Remove the refusals of an episode that arrived whole."""
        if self.ledger.remove_refusal(marker.name):
            self.say(f"episode {marker.name} came whole now")
            self.store.delete(f"refused/{marker.name}.json")
        (self.folder / f"{marker.name}.npz").unlink(missing_ok=True)
        if self.ledger.taken(marker.seq):
            self.say(f"episode {marker.seq} came twice, with different content: both are learned from")


def refuse_wrong_arrays(episode: Episode, steps: int) -> None:
    """Raises ValueError where arrays are not of `steps` steps, not of the right kind, or not finite."""
    poses = (episode.pose, *([] if episode.estimate is None else [episode.estimate]))
    if any(pose.shape != (steps + 1, 3) or pose.dtype != np.float64 or not np.isfinite(pose).all() for pose in poses):
        raise ValueError(f"it holds no {steps + 1} poses")
    if [(moves.shape, moves.dtype.kind) for moves in (episode.action, episode.collided)] != [((steps,), "i"),
                                                                                             ((steps,), "b")]:
        raise ValueError(f"it holds no {steps} moves")
    if not all(isinstance(event, dict) for event in episode.events) or not isinstance(episode.dock, dict | None):
        raise ValueError("its events are none")


def most_bytes(steps: int) -> int:
    """Bytes that an episode of `steps` steps has at most, packed or not."""
    return (steps + 1) * STEP + TEXT_BYTES


def refuse_bombs(raw: bytes) -> None:
    """Raises ValueError for an archive whose table of contents is larger than that of an episode."""
    end = raw[-22:]
    if len(end) < 22 or end[:4] != b"PK\5\6" or raw[-42:-38] == b"PK\6\7":  # the latter: a second, longer table
        raise ValueError("it is no archive as numpy writes it")
    entries, size = struct.unpack("<10xHI6x", end)
    if entries not in (len(MEMBERS), len(MEMBERS | ESTIMATE)) or size > 1 << 12:
        raise ValueError("its table of contents is not that of an episode")
