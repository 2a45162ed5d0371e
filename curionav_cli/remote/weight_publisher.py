"""How a server makes weights known: the object, read back, then the pointer to it. After a crash in between, once more.

All of it is a function of what was trained, so that doing it again changes nothing.
"""

from __future__ import annotations

import json
from collections.abc import Callable

from curionav_cli.errors import RunFailed, Unreachable
from curionav_cli.remote.ledger import Ledger
from curionav_cli.remote.object_store import ObjectStore, TooLarge
from curionav_cli.remote.protocol import LATEST, SMALL, TRAINER, Pointer, parsed, sha256, written

KEPT = 3  # versions in the storage: a robot may be fetching one when the next comes


class WeightPublisher:
    """settings: the fingerprint that robots compare."""

    def __init__(self, store: ObjectStore, ledger: Ledger, settings: str, say: Callable[[str], None]):
        self.store, self.ledger, self.settings, self.say = store, ledger, settings, say
        self.warned = False

    def publish(self, version: int, raw: bytes) -> None:
        """Weights after `version` episodes. Raises Unreachable, and RunFailed where another server is at work."""
        pointer = Pointer(version, sha256(raw), len(raw), self.settings, self.ledger.newest())
        there = self.refuse_others(pointer)
        self.ledger.publish(version, pointer.sha256)
        if there and there.version > version:  # it went on from an older checkpoint; robots have newer ones of it
            return
        if there == pointer and self.store.size(pointer.key) == pointer.size:
            return
        self.write(pointer.key, raw)
        self.write(LATEST, written(pointer))
        former = self.ledger.version(version - KEPT)
        if former:
            self.store.delete(f"weights/{version - KEPT:06d}-{former[:16]}.safetensors")

    def write(self, key: str, raw: bytes) -> None:
        """Put it there and read it back. Raises Unreachable where it comes back as something else."""
        self.store.put(key, raw)
        try:
            back = self.store.get(key, len(raw))
        except TooLarge:
            back = None
        if back != raw:
            raise Unreachable(f"{key} comes back as something else than was put there")

    def refuse_others(self, ours: Pointer) -> Pointer | None:
        """What LATEST says now, if it can be read. Raises RunFailed where it is neither `ours` nor an earlier one."""
        try:
            there = parsed(Pointer, self.store.get(LATEST, SMALL) or b"")
        except ValueError:
            return None
        if there != ours and self.ledger.version(there.version) != there.sha256:
            raise RunFailed(f"The storage has weights of version {there.version} that are not of this training. Go "
                            "on in the folder of the training that made them, or use an empty place for storage=...")
        return there

    def announce(self) -> None:
        """Say that this server is at work, and whether another says so too: a warning, no lock."""
        try:
            other = json.loads(self.store.get(TRAINER, SMALL) or b"{}").get("trainer")
        except (ValueError, AttributeError, RecursionError):
            other = None
        if other not in (None, self.ledger.trainer) and not self.warned:
            self.warned = True
            self.say("another curionav train says that it serves this storage. One of the two is too many.")
        if other is None:
            self.store.put(TRAINER, json.dumps({"trainer": self.ledger.trainer}).encode())
