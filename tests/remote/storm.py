"""Faults of uploads to any kind of storage, between the caller of `put` and the storage."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from bad_server import flipped

from curionav_cli.errors import Unreachable
from curionav_cli.remote.object_store import ObjectStore

DAMAGED: dict[str, Callable[[bytes], bytes]] = {
    "truncate": lambda raw: raw[:len(raw) // 3], "flip": flipped, "empty": lambda raw: b"",
    "break off": lambda raw: raw[:len(raw) // 2],
}
REASONS = {"break off": "the connection broke off", "refuse": "it is not able to answer now",
        "full": "it has no place for what is put there"}
KINDS = ("truncate", "flip", "empty", "break off", "lose", "refuse", "full", "twice")


class Storm:
    """faults: kinds, each for the next object whose key contains `part`; struck: the keys that were hit."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, part: str = ""):
        self.part, self.faults, self.struck, self.plain = part, list[str](), list[str](), ObjectStore.put
        monkeypatch.setattr(ObjectStore, "put", lambda store, key, raw: self.put(store, key, raw))

    def put(self, store: ObjectStore, key: str, raw: bytes | Path) -> None:
        kind = self.faults.pop(0) if self.faults and self.part in key else ""
        if kind:
            self.struck.append(key)
        whole = raw.read_bytes() if isinstance(raw, Path) else raw
        if kind not in ("lose", "refuse", "full"):
            self.plain(store, key, DAMAGED[kind](whole) if kind in DAMAGED else raw)
        if kind == "twice":
            self.plain(store, key, raw)
        if kind in REASONS:
            raise Unreachable(REASONS[kind])
