"""What robot and server write for each other, and where (paper, section "Lifelong learning").

    settings.json                 what both must agree on; by whoever comes first
    episodes/000003-<sha>.npz     an episode, named by its number and its SHA-256; by the robot, never changed
    episodes/000003-<sha>.json    its marker, written after it: now it counts
    refused/000003-<sha>.json     by the server: the object was not what its marker says, send it again
    weights/000004-<sha>.safetensors   after four trained episodes; by the server
    weights/LATEST.json           the pointer to the newest, written after it
    trainer.json                  which server is at work: a second one is warned

One writer a folder, so that no conditional writes are needed. No clock has a say: order is that of numbers. Whatever
comes from the storage may be hostile: names are matched, JSON is bounded and typed, nothing is ever unpickled.
"""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import asdict, dataclass, fields
from typing import Any, TypeVar

SMALL = 1 << 16  # bytes that a JSON object here may have
SHA = re.compile(r"[0-9a-f]{64}")
MARKED = re.compile(r"\d{6,9}-[0-9a-f]{16}\.json")
PLAIN = re.compile(r"[\x20-\x7e]{0,200}")
LATEST, SETTINGS, TRAINER = "weights/LATEST.json", "settings.json", "trainer.json"

T = TypeVar("T")


@dataclass(frozen=True)
class Marker:
    """Says that an episode is there. seq: its number in the robot's life; weights: the version that acted.

    boot, monotonic and wall (seconds) say when it was lived, for people; nothing is decided by them.
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
        return f"{self.seq:06d}-{self.sha256[:16]}"


@dataclass(frozen=True)
class Pointer:
    """Says which weights are the newest. version: how many episodes they were trained on; seq: the newest of them."""

    version: int
    sha256: str
    size: int
    settings: str
    seq: int

    @property
    def name(self) -> str:
        return f"{self.version:06d}-{self.sha256[:16]}"

    @property
    def key(self) -> str:
        return f"weights/{self.name}.safetensors"


@dataclass(frozen=True)
class Refusal:
    """Says that an episode could not be used; times: how often by now, which makes a new one of it each time."""

    times: int
    reason: str


def written(note: Any) -> bytes:
    return sealed(asdict(note))


def sealed(held: dict[str, Any]) -> bytes:
    """JSON with a checksum of itself: a storage may flip a bit where it still reads well."""
    return json.dumps({**held, "check": seal(held)}).encode()


def seal(held: dict[str, Any]) -> str:
    return fingerprint(held)[:16]


def parsed(kind: type[T], raw: bytes) -> T:
    """A note of this kind. Raises ValueError where it is none."""
    try:
        held = json.loads(raw)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    if not isinstance(held, dict):
        raise ValueError("it is no JSON object")
    if held.pop("check", None) != seal(held):
        raise ValueError("its checksum is another one")
    values = {}
    for field in fields(kind):  # type: ignore[arg-type]
        value = held.get(field.name)
        if not fits(field.name, str(field.type), value):
            raise ValueError(f"its {field.name} is not what it should be")
        values[field.name] = value
    return kind(**values)


def fits(name: str, kind: str, value: Any) -> bool:
    """Whether a value read from JSON can be that field's."""
    if kind == "int":
        return type(value) is int and 0 <= value < (10**9 if name == "seq" else 2**53)
    if kind == "float":
        return type(value) in (int, float) and abs(value) < 1e18
    if name in ("sha256", "settings"):
        return isinstance(value, str) and SHA.fullmatch(value) is not None
    return isinstance(value, str) and PLAIN.fullmatch(value) is not None


def fingerprint(settings: dict[str, Any]) -> str:
    """SHA-256 of what both sides must agree on."""
    return sha256(json.dumps(settings, sort_keys=True).encode())


def sha256(raw: bytes) -> str:
    return hashlib.sha256(raw).hexdigest()
