"""The robot's outbox: episodes not yet delivered, on its own disk, so that neither a crash nor the network loses them.

    outbox/
        000003-<sha>.npz    the episode, the same file as in episodes/ (a hard link)
        000003-<sha>.json   its marker, written last: an episode without one is not in the outbox
        sent/               markers of delivered episodes, in case the server asks for one again
"""

from __future__ import annotations

import os
import shutil
import time
import uuid
from pathlib import Path

from curionav_cli.errors import RunFolderError
from curionav_cli.files import write_bytes
from curionav_cli.records import Episode
from curionav_cli.remote.protocol import Marker, parsed, sha256, written
from curionav_cli.storage.checkpoint import flush


class Outbox:
    """Episodes that wait in `folder`.

    settings: the fingerprint that every marker carries. most: episodes, and share: of the disk that may be filled,
    before the outbox is full.
    """

    def __init__(self, folder: Path, settings: str, most: int, share: float):
        self.folder, self.settings, self.most, self.share = folder, settings, most, share
        self.sent = folder / "sent"
        self.sent.mkdir(parents=True, exist_ok=True)

    def add(self, seq: int, path: Path, episode: Episode, weights: int) -> Marker:
        """Add episode `seq`, saved at `path` and recorded with this version of the weights; its marker.

        Adding the same episode again changes nothing.
        """
        digest = sha256(path.read_bytes())
        marker = Marker(seq, digest, path.stat().st_size, len(episode), weights, self.settings, boot(),
                        time.monotonic(), time.time())
        if not (self.sent / f"{marker.name}.json").exists():
            link(path, self.data(marker))
            write_bytes(self.folder / f"{marker.name}.json", written(marker))
            flush(self.folder)
        return marker

    def waiting(self) -> list[Marker]:
        """Markers of the episodes to deliver, in order. Raises RunFolderError where one is broken."""
        return [noted(path) for path in sorted(self.folder.glob("*.json"))]

    def recorded(self, seq: int, weights: int) -> bool:
        """Whether episode `seq` was recorded with this version of the weights before: it waits here or was sent."""
        notes = [path for folder in (self.folder, self.sent) for path in folder.glob(f"{seq:06d}-*.json")]
        return any(noted(path).weights == weights for path in notes)

    def data(self, marker: Marker) -> Path:
        """The file of an episode that waits."""
        return self.folder / f"{marker.name}.npz"

    def deliver(self, marker: Marker) -> None:
        """Take an episode that has arrived out of the outbox."""
        note = self.folder / f"{marker.name}.json"
        note.replace(self.sent / note.name)
        self.data(marker).unlink(missing_ok=True)
        flush(self.folder)

    def delivered(self, name: str) -> Marker | None:
        """The marker of a delivered episode; None where no such episode was delivered."""
        path = self.sent / f"{name}.json"
        return noted(path) if path.exists() else None

    def full(self) -> str:
        """Why the outbox takes no further episode; '' where it does."""
        waiting = len(list(self.folder.glob("*.json")))
        if waiting >= self.most:
            return f"{waiting} episodes wait in {self.folder} (remote.outbox={self.most})"
        usage = shutil.disk_usage(self.folder)
        if waiting and usage.used > self.share * usage.total:
            return f"the disk of {self.folder} is filled to {usage.used / usage.total:.0%} (remote.disk={self.share:g})"
        return ""


def noted(path: Path) -> Marker:
    """The marker in a file. Raises RunFolderError where it is broken."""
    try:
        return parsed(Marker, path.read_bytes())
    except ValueError as error:
        raise RunFolderError(f"{path} cannot be read ({error}). Remove it; the episode is in episodes/.") from error


def link(path: Path, to: Path) -> None:
    """Give a file a second name; copy it on file systems without hard links."""
    to.unlink(missing_ok=True)
    try:
        os.link(path, to)
    except OSError:
        shutil.copyfile(path, to)
        flush(to)


def boot() -> str:
    """The id of this boot of the machine; monotonic clocks of different boots cannot be compared."""
    path = Path("/proc/sys/kernel/random/boot_id")
    return path.read_text().strip() if path.exists() else str(uuid.uuid4())
