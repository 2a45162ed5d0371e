"""What a robot has lived and not yet delivered: on its own disk, so that neither a crash nor the network loses it.

    outbox/
        000003-<sha>.npz    the episode, the same file as in episodes/ (a hard link)
        000003-<sha>.json   its marker, written last: what has none is not in the outbox
        sent/               markers of what was delivered, in case the server wants it again
"""

from __future__ import annotations

import os
import shutil
import time
import uuid
from pathlib import Path

from curionav_cli.errors import RunFolderError
from curionav_cli.files import write_whole
from curionav_cli.records import Episode
from curionav_cli.remote.protocol import Marker, parsed, sha256, written
from curionav_cli.storage.checkpoint import flush


class Outbox:
    """settings: the fingerprint that every marker carries. most: episodes; share: of the disk, before it is full."""

    def __init__(self, folder: Path, settings: str, most: int, share: float):
        self.folder, self.settings, self.most, self.share = folder, settings, most, share
        self.sent = folder / "sent"
        self.sent.mkdir(parents=True, exist_ok=True)

    def add(self, seq: int, path: Path, episode: Episode, weights: int) -> Marker:
        """Episode `seq` that was saved at `path`, lived with this version. The same one again changes nothing."""
        digest = sha256(path.read_bytes())
        marker = Marker(seq, digest, path.stat().st_size, len(episode), weights, self.settings, boot(),
                        time.monotonic(), time.time())
        if not (self.sent / f"{marker.name}.json").exists():
            link(path, self.data(marker))
            write_whole(self.folder / f"{marker.name}.json", lambda file: file.write(written(marker)))
            flush(self.folder)
        return marker

    def waiting(self) -> list[Marker]:
        """In the order in which they were lived."""
        return [noted(path) for path in sorted(self.folder.glob("*.json"))]

    def recorded(self, seq: int, weights: int) -> bool:
        """Whether episode `seq` was lived with this version before, and is or was in here."""
        notes = [path for folder in (self.folder, self.sent) for path in folder.glob(f"{seq:06d}-*.json")]
        return any(noted(path).weights == weights for path in notes)

    def data(self, marker: Marker) -> Path:
        return self.folder / f"{marker.name}.npz"

    def deliver(self, marker: Marker) -> None:
        """It has arrived."""
        note = self.folder / f"{marker.name}.json"
        note.replace(self.sent / note.name)
        self.data(marker).unlink(missing_ok=True)
        flush(self.folder)

    def delivered(self, name: str) -> Marker | None:
        """What was sent under this name, if it was."""
        path = self.sent / f"{name}.json"
        return noted(path) if path.exists() else None

    def full(self) -> str:
        """Why there is no room for another episode; '' while there is."""
        waiting = len(list(self.folder.glob("*.json")))
        if waiting >= self.most:
            return f"{waiting} episodes wait in {self.folder} (remote.outbox={self.most})"
        usage = shutil.disk_usage(self.folder)
        if waiting and usage.used > self.share * usage.total:
            return f"the disk of {self.folder} is filled to {usage.used / usage.total:.0%} (remote.disk={self.share:g})"
        return ""


def noted(path: Path) -> Marker:
    """Raises RunFolderError for a marker that the disk has spoilt."""
    try:
        return parsed(Marker, path.read_bytes())
    except ValueError as error:
        raise RunFolderError(f"{path} cannot be read ({error}). Remove it; the episode is in episodes/.") from error


def link(path: Path, to: Path) -> None:
    """Two names for one file; a copy on file systems that have no links."""
    to.unlink(missing_ok=True)
    try:
        os.link(path, to)
    except OSError:
        shutil.copyfile(path, to)
        flush(to)


def boot() -> str:
    """Which boot of the machine this is; monotonic clocks are to be compared within one only."""
    path = Path("/proc/sys/kernel/random/boot_id")
    return path.read_text().strip() if path.exists() else str(uuid.uuid4())
