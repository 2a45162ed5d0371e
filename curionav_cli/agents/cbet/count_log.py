"""Counts that are never cleared, in a file beside the checkpoints that only grows: a save costs what one episode adds.

    checkpoint/
        counts.log     a block a save: of each table its cleared flag, number of keys and bytes of a key (uint32 each),
                       then the keys that were counted since the last save, and their counts (int64)
        000004/        its memory.json has `log`: how many bytes of the file are its own, and their SHA-256

What follows those bytes is of a later save; a run that goes on from a checkpoint cuts it off.
"""

from __future__ import annotations

import hashlib
import os
import struct
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.agents.cbet.counts import Counts, Table
from curionav_cli.errors import RunFolderError

NAME = "counts.log"
HEAD = struct.Struct("<III")


class CountLog:
    """What was written so far, and where; nothing yet of an agent that begins."""

    def __init__(self) -> None:
        self.path: Path | None = None
        self.size, self.digest = 0, hashlib.sha256()

    def append(self, path: Path, counts: Mapping[str, Counts]) -> dict[str, Any]:
        """Append what changed since the last time, and flush it to the disk; returns what a checkpoint notes of it.

        At another path than before, or where the file was taken away, everything is written, into a new file.
        """
        begins = path != self.path or not path.is_file() or path.stat().st_size < self.size
        if begins:
            self.path, self.size, self.digest = path, 0, hashlib.sha256()
        block = b"".join(packed(*part) for one in counts.values() for part in one.news(everything=begins))
        with open(path, "wb" if begins else "r+b") as file:
            file.seek(self.size)
            file.write(block)
            file.truncate()
            file.flush()
            os.fsync(file.fileno())
        self.size += len(block)
        self.digest.update(block)
        return {"bytes": self.size, "sha256": self.digest.hexdigest()}

    def read(self, path: Path, noted: Mapping[str, Any], counts: Mapping[str, Counts]) -> None:
        """Restore the tables from the bytes that a checkpoint notes. Raises RunFolderError where they are others."""
        try:
            with open(path, "rb") as file:
                content = file.read(noted["bytes"])
        except OSError as error:
            raise RunFolderError(f"{path} cannot be read ({error.strerror}). Restore it from a copy.") from error
        digest = hashlib.sha256(content)
        if (len(content), digest.hexdigest()) != (noted["bytes"], noted["sha256"]):
            raise RunFolderError(f"{path} is not whole (its checksum is another one). Restore it from a copy.")
        tables = [table for one in counts.values() for table in one.tables]
        for table in tables:
            table.clear()
        for number, (cleared, entries) in enumerate(unpacked(content)):
            table = tables[number % len(tables)]
            if cleared:
                table.clear()
            table.update(entries)
        for one in counts.values():
            one.forget_news()
        self.path, self.size, self.digest = path, len(content), digest


def packed(cleared: bool, entries: Table) -> bytes:
    """The part of a block that is about one table. entries: keys of one length, and their counts."""
    width = len(next(iter(entries), b""))
    numbers = np.fromiter(entries.values(), np.dtype("<i8"), len(entries))
    return HEAD.pack(cleared, len(entries), width) + b"".join(entries) + numbers.tobytes()


def unpacked(content: bytes) -> Iterator[tuple[bool, Table]]:
    """Whether a table was cleared, and its entries, of each part of each block."""
    at = 0
    while at < len(content):
        cleared, number, width = HEAD.unpack_from(content, at)
        keys = at + HEAD.size
        at = keys + number * (width + 8)
        count = np.frombuffer(content, np.dtype("<i8"), number, keys + number * width).tolist()
        yield bool(cleared), {content[keys + width * n:keys + width * (n + 1)]: count[n] for n in range(number)}
