"""Faults that strike on any kind of storage: between those who put objects and the storage that gets them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from bad_server import flipped

from curionav_cli.errors import Unreachable
from curionav_cli.remote.object_store import ObjectStore

SPOILT: dict[str, Callable[[bytes], bytes]] = {
    "truncate": lambda raw: raw[:len(raw) // 3], "flip": flipped, "empty": lambda raw: b"",
    "break off": lambda raw: raw[:len(raw) // 2],
}
TOLD = {"break off": "the connection broke off", "refuse": "it is not able to answer now",
        "full": "it has no place for what is put there"}
KINDS = ("truncate", "flip", "empty", "break off", "lose", "refuse", "full", "twice")


class Storm:
    """faults: kinds, each for the next object whose key contains `part`; struck: what was hit."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, part: str = ""):
        self.part, self.faults, self.struck, self.plain = part, list[str](), list[str](), ObjectStore.put
        monkeypatch.setattr(ObjectStore, "put", lambda store, key, raw: self.put(store, key, raw))

    def put(self, store: ObjectStore, key: str, raw: bytes | Path) -> None:
        kind = self.faults.pop(0) if self.faults and self.part in key else ""
        if kind:
            self.struck.append(key)
        whole = raw.read_bytes() if isinstance(raw, Path) else raw
        if kind not in ("lose", "refuse", "full"):
            self.plain(store, key, SPOILT[kind](whole) if kind in SPOILT else raw)
        if kind == "twice":
            self.plain(store, key, raw)
        if kind in TOLD:
            raise Unreachable(TOLD[kind])
