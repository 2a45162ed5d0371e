"""What the entry point answered, for the tests that type commands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Answer:
    code: int
    out: str
    error: str


Cli = Callable[..., Answer]
