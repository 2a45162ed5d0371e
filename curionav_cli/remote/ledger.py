"""The server's ledger: which episodes it has taken, in which order, and which weights it has published.

It is in SQLite, so that a row is whole or absent. A row is written before the episode is learned from, the checkpoint
(storage/checkpoint.py) after it: position n is trained once checkpoint n + 1 is finished. Rows beyond the newest
checkpoint are of interrupted training, which is done again.
"""

from __future__ import annotations

import errno
import sqlite3
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from curionav_cli.errors import RunFolderError
from curionav_cli.remote.protocol import Marker

TABLES = """
create table if not exists episodes (position integer primary key, name text unique, seq integer, sha256 text,
                                     steps integer, weights integer, boot text, monotonic real, wall real);
create table if not exists refused (name text primary key, times integer, reason text);
create table if not exists versions (version integer primary key, sha256 text);
create table if not exists trainer (id text);
"""


class Ledger:
    """The ledger in the file `path`.

    All methods raise RunFolderError where the file is broken, OSError where the disk is full.
    """

    def __init__(self, path: Path):
        self.path = path
        with self.translated():
            self.rows = sqlite3.connect(path, isolation_level=None)
            self.rows.executescript(TABLES)
        self.do("insert into trainer select ? where not exists (select * from trainer)", uuid.uuid4().hex)

    @property
    def trainer(self) -> str:
        """The server's own random name."""
        return str(self.one("select id from trainer"))

    def take(self, marker: Marker) -> int:
        """Note that an episode is learned from; its position, the same for the same episode."""
        before = self.one("select position from episodes where name = ?", marker.name)
        if before is not None:
            return int(before)
        position = int(self.one("select count(*) from episodes"))
        self.do("insert into episodes values (?, ?, ?, ?, ?, ?, ?, ?, ?)",
                position, marker.name, marker.seq, marker.sha256, marker.steps, marker.weights, marker.boot,
                marker.monotonic, marker.wall)
        return position

    def rewind(self, trained: int) -> list[str]:
        """Remove rows beyond the first `trained`; their names, in order. Raises RunFolderError if rows are missing."""
        count = int(self.one("select count(*) from episodes where position < ?", trained))
        if count < trained:
            raise RunFolderError(f"ledger.sqlite holds {count} of {trained} trained episodes. Restore it from a copy.")
        later = [str(name) for (name,) in self.do(
            "select name from episodes where position >= ? order by position", trained)]
        self.do("delete from episodes where position >= ?", trained)
        return later

    def names(self) -> set[str]:
        """Names of all episodes that were taken."""
        return {name for (name,) in self.do("select name from episodes")}

    def newest(self) -> int:
        """The highest number of an episode that was taken; -1 before the first."""
        return int(self.one("select coalesce(max(seq), -1) from episodes"))

    def taken(self, seq: int) -> int:
        """How many episodes of this number were taken: more than one if they differ in content."""
        return int(self.one("select count(*) from episodes where seq = ?", seq))

    def refuse(self, name: str, reason: str) -> int:
        """Note a refusal; how often the episode was refused so far."""
        self.do("insert into refused values (?, 1, ?) on conflict (name) do "
                "update set times = times + 1, reason = excluded.reason", name, reason)
        return int(self.one("select times from refused where name = ?", name))

    def remove_refusal(self, name: str) -> bool:
        """Remove what `refuse` noted; whether there was any."""
        count = self.one("select count(*) from refused where name = ?", name)
        self.do("delete from refused where name = ?", name)
        return bool(count)

    def refused(self) -> dict[str, str]:
        """Name -> reason of episodes that the robot has to send again."""
        return dict(self.do("select name, reason from refused order by name"))

    def publish(self, version: int, sha256: str) -> None:
        """Note the weights of a version."""
        self.do("insert or replace into versions values (?, ?)", version, sha256)

    def version(self, number: int) -> str | None:
        """The SHA-256 of the weights of a version; None where this server did not publish it."""
        sha256 = self.one("select sha256 from versions where version = ?", number)
        return None if sha256 is None else str(sha256)

    def close(self) -> None:
        """Close the file."""
        self.rows.close()

    def one(self, query: str, *values: object) -> Any:
        """The first value of a query; None where it gives no row."""
        rows = self.do(query, *values)
        return rows[0][0] if rows else None

    def do(self, query: str, *values: object) -> list[Any]:
        """All rows of a query."""
        with self.translated():
            return self.rows.execute(query, values).fetchall()

    @contextmanager
    def translated(self) -> Iterator[None]:
        """Turn SQLite's errors into ours."""
        try:
            yield
        except sqlite3.Error as error:
            if "full" in str(error):
                raise OSError(errno.ENOSPC, str(error), str(self.path)) from error
            raise RunFolderError(f"{self.path} cannot be used ({error}). Restore it from a copy.") from error
