"""The file RUN/wandb/offline-run-.../run-ID.wandb: a LevelDB log of wandb's records behind a header of seven bytes.

wandb says nothing where its disk is full: the file ends early, and finish() succeeds. So it is read again at the end.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

HEADER, BLOCK, HEAD = 7, 32768, 7  # bytes: of the file's header, a block of the log, the head of a record's part
WHOLE, LAST = 1, 4  # kinds of a part: a whole record, or the end of one
PATIENCE = 20.0  # seconds: finish() returns before the last records are on the disk


def records(path: Path) -> Iterator[bytes]:
    """Yield the serialised records that the file holds, up to where it ends."""
    raw, at, record = path.read_bytes(), HEADER, b""
    while at + HEAD <= len(raw):
        if BLOCK - at % BLOCK < HEAD:
            at += BLOCK - at % BLOCK
            continue
        size, kind = int.from_bytes(raw[at + 4:at + 6], "little"), raw[at + 6]
        part = raw[at + HEAD:at + HEAD + size]
        if len(part) < size or not kind:
            return
        record, at = record + part, at + HEAD + size
        if kind in (WHOLE, LAST):
            yield record
            record = b""


def held(path: Path) -> tuple[int, bool]:
    """The number of rows that the file holds, and whether its end is there."""
    from wandb.proto import wandb_internal_pb2

    form: Any = wandb_internal_pb2  # chosen by the version of protobuf
    kinds = [form.Record.FromString(raw).WhichOneof("record_type") for raw in records(path)]
    return kinds.count("history"), "exit" in kinds


def refuse_lost(path: Path, rows: int) -> None:
    """Raises OSError where the file of a finished run does not come to hold `rows` rows and its end."""
    until = time.monotonic() + PATIENCE
    while (found := held(path)) != (rows, True):
        if time.monotonic() > until:
            end = "" if found[1] else " and no end"
            raise OSError(f"{path} holds {found[0]} of {rows} rows{end}; is the disk full?")
        time.sleep(0.1)
