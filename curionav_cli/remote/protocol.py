"""The objects that robot and server exchange, and their keys (paper, section "Lifelong learning").

    settings.json                 the settings that both must agree on; by whichever comes first
    episodes/000003-<sha>.npz     an episode, named by its number and its SHA-256; by the robot, never changed
    episodes/000003-<sha>.json    its marker, written after it: only a marked episode counts
    refused/000003-<sha>.json     by the server: the episode was not what its marker states, send it again
    weights/000004-<sha>.safetensors   weights trained on four episodes; by the server
    weights/LATEST.json           the pointer to the newest, written after it
    trainer.json                  the server at work, so that a second one is warned

One writer a folder, so that no conditional writes are needed. Order is that of numbers, never of clocks. Whatever
comes from the storage may be hostile: names are matched, JSON is bounded and typed, nothing is ever unpickled.
"""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import asdict, dataclass, fields
from typing import Any, TypeVar

from curionav_cli.errors import RunFolderError
from curionav_cli.files import Seal
from curionav_cli.remote.object_store import ObjectStore
from curionav_cli.storage.checkpoint import differences

SMALL = 1 << 16  # bytes that a note may have
LARGEST = 1 << 20  # bytes that settings.json may have
SHA = re.compile(r"[0-9a-f]{64}")
MARKED = re.compile(r"\d{6,9}-[0-9a-f]{16}\.json")
PLAIN = re.compile(r"[\x20-\x7e]{0,200}")
LATEST, SETTINGS, TRAINER = "weights/LATEST.json", "settings.json", "trainer.json"

T = TypeVar("T")


@dataclass(frozen=True)
class Marker:
    """The note that an episode is complete. seq: its number in the robot's run; weights: the version that acted.

    size: bytes of the episode; steps: its length; settings: the fingerprint of the run's. boot, monotonic and wall
    (seconds) tell people when it was recorded; nothing is decided by them.
    """

    seq: int
    sha256: str
    size: int
    steps: int
    weights: int
    settings: str
    boot: str
    monotonic: float
    wall: float

    @property
    def name(self) -> str:
        """The episode's name: its number and the beginning of its SHA-256."""
        return f"{self.seq:06d}-{self.sha256[:16]}"


@dataclass(frozen=True)
class Pointer:
    """The note that names the newest weights.

    version: number of episodes they were trained on; seq: the newest of these; size: bytes of the weights; settings:
    the fingerprint of the run's.
    """

    version: int
    sha256: str
    size: int
    settings: str
    seq: int

    @property
    def name(self) -> str:
        """The weights' name: their version and the beginning of their SHA-256."""
        return f"{self.version:06d}-{self.sha256[:16]}"

    @property
    def key(self) -> str:
        """The key of the weights in the storage."""
        return f"weights/{self.name}.safetensors"


@dataclass(frozen=True)
class Refusal:
    """The note that an episode could not be used. times: how often so far, so that each refusal is answered once."""

    times: int
    reason: str


def fingerprint(settings: dict[str, Any]) -> str:
    """SHA-256 of the JSON of a dictionary, such as the settings that both sides must agree on."""
    return sha256(json.dumps(settings, sort_keys=True).encode())


def sha256(raw: bytes) -> str:
    """The SHA-256 of bytes, in hexadecimal."""
    return hashlib.sha256(raw).hexdigest()


SEAL = Seal("check", lambda plain: fingerprint(plain)[:16])


def written(note: Any) -> bytes:
    """The JSON of a Marker, Pointer or Refusal, with a checksum of itself."""
    return SEAL.sealed(asdict(note)).encode()


def parsed(kind: type[T], raw: bytes) -> T:
    """The note of this kind that `written` wrote. Raises ValueError for anything else."""
    try:
        held = json.loads(raw)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    if not isinstance(held, dict):
        raise ValueError("it is no JSON object")
    if not SEAL.removed(held):
        raise ValueError("its checksum is another one")
    values = {}
    for field in fields(kind):  # type: ignore[arg-type]
        value = held.get(field.name)
        if not fits(field.name, str(field.type), value):
            raise ValueError(f"its {field.name} is not what it should be")
        values[field.name] = value
    return kind(**values)


def fits(name: str, kind: str, value: Any) -> bool:
    """Whether a value read from JSON can be that of the field `name`, annotated as `kind`."""
    if kind == "int":
        return type(value) is int and 0 <= value < (10**9 if name == "seq" else 2**53)
    if kind == "float":
        return type(value) in (int, float) and abs(value) < 1e18
    if name in ("sha256", "settings"):
        return isinstance(value, str) and SHA.fullmatch(value) is not None
    return isinstance(value, str) and PLAIN.fullmatch(value) is not None


def agree_on_settings(store: ObjectStore, settings: dict[str, Any]) -> None:
    """Write settings.json, or compare with what the other side wrote.

    Raises RunFolderError that names the first setting that differs, and Unreachable.
    """
    try:
        raw = store.get(SETTINGS, LARGEST)
        agreed = None if raw is None else json.loads(raw)
    except (ValueError, RecursionError):
        raise RunFolderError("storage: its settings.json is broken. Remove it.") from None
    if raw is None:
        store.put(SETTINGS, json.dumps(settings, indent=2).encode())
        return
    differing = differences(agreed, json.loads(json.dumps(settings)))
    if differing:
        raise RunFolderError(f"storage: it is used with other settings: {differing[0]}. Robot and server need the "
                             "same, and every run a place of its own.")
