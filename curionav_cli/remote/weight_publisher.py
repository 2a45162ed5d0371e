"""Publishing weights: put the object, read it back, then put the pointer to it.

What is published depends on the training alone, so that publishing again after a crash changes nothing.
"""

from __future__ import annotations

import json
from collections.abc import Callable

from curionav_cli.errors import RunFailed, Unreachable
from curionav_cli.remote.ledger import Ledger
from curionav_cli.remote.object_store import ObjectStore, TooLarge
from curionav_cli.remote.protocol import LATEST, SMALL, TRAINER, Pointer, parsed, sha256, written

KEPT = 3  # versions in the storage: a robot may be reading one while the next is published


class WeightPublisher:
    """Publishes weights in a storage. settings: the fingerprint that robots compare. say: prints a line."""

    def __init__(self, store: ObjectStore, ledger: Ledger, settings: str, say: Callable[[str], None]):
        self.store, self.ledger, self.settings, self.say = store, ledger, settings, say
        self.warned = False

    def publish(self, version: int, raw: bytes) -> None:
        """Publish weights trained on `version` episodes.

        Raises Unreachable, and RunFailed where another server published to this storage.
        """
        pointer = Pointer(version, sha256(raw), len(raw), self.settings, self.ledger.newest())
        latest = self.refuse_others(pointer)
        self.ledger.publish(version, pointer.sha256)
        if latest and latest.version > version:  # resumed from an older checkpoint, after publishing newer weights
            return
        if latest == pointer and self.store.size(pointer.key) == pointer.size:
            return
        self.write(pointer.key, raw)
        self.write(LATEST, written(pointer))
        former = self.ledger.version(version - KEPT)
        if former:
            self.store.delete(f"weights/{version - KEPT:06d}-{former[:16]}.safetensors")

    def write(self, key: str, raw: bytes) -> None:
        """Put an object and read it back. Raises Unreachable where it comes back changed."""
        self.store.put(key, raw)
        try:
            back = self.store.get(key, len(raw))
        except TooLarge:
            back = None
        if back != raw:
            raise Unreachable(f"{key} comes back as something else than was put there")

    def refuse_others(self, ours: Pointer) -> Pointer | None:
        """The pointer LATEST, if it can be read. Raises RunFailed where this server published no such weights."""
        try:
            latest = parsed(Pointer, self.store.get(LATEST, SMALL) or b"")
        except ValueError:
            return None
        if latest != ours and self.ledger.version(latest.version) != latest.sha256:
            raise RunFailed(f"The storage has weights of version {latest.version} that are not of this training. Go "
                            "on in the folder of the training that made them, or use an empty place for storage=...")
        return latest

    def announce(self) -> None:
        """Note in the storage that this server is at work, and warn where another is; this locks nothing."""
        try:
            other = json.loads(self.store.get(TRAINER, SMALL) or b"{}").get("trainer")
        except (ValueError, AttributeError, RecursionError):
            other = None
        if other not in (None, self.ledger.trainer) and not self.warned:
            self.warned = True
            self.say("another curionav train says that it serves this storage. One of the two is too many.")
        if other is None:
            self.store.put(TRAINER, json.dumps({"trainer": self.ledger.trainer}).encode())
