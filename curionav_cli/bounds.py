"""Range checks of the settings' schemas."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

Range = tuple[float, float]
Limits = Mapping[str, Range]
_notes: list[dict[str, Range]] = []


@contextmanager
def noted() -> Iterator[dict[str, Range]]:
    """Note the ranges that are checked meanwhile, by key: the reference of settings is written from them."""
    _notes.append({})
    try:
        yield _notes[-1]
    finally:
        _notes.pop()


def note(key: str, least: float, most: float) -> None:
    for notes in _notes:
        notes[key] = least, most


def a_name(key: str, name: str) -> None:
    """Raises ValueError unless `name` can be part of a run folder's name."""
    if not name or name.startswith(".") or "/" in name or "\\" in name or not name.isprintable() or len(name) > 100:
        raise ValueError(f"{key}: {name!r} is no name; it may not hold slashes or begin with a dot")


def within(key: str, value: float, least: float, most: float) -> None:
    """Raises ValueError with 'key: ...' unless least <= value <= most (nan is never within)."""
    note(key, least, most)
    if not least <= value <= most:
        raise ValueError(f"{key}: {value} is not between {least} and {most}")


def bounded(key: str, settings: object, limits: Limits) -> None:
    """Check the fields of the dataclass at `key`; limits: names, separated by spaces -> (least, most).

    Raises ValueError as `within` does.
    """
    for names, (least, most) in limits.items():
        for name in names.split():
            within(f"{key}.{name}", getattr(settings, name), least, most)


def a_number(key: str, value: object, least: float, most: float) -> None:
    """Raises ValueError with 'key must be ...' unless `value`, of any type, is a number from least to most."""
    note(key, least, most)
    if isinstance(value, bool) or not isinstance(value, int | float) or not least <= value <= most:
        raise ValueError(f"{key} must be a number from {least:g} to {most:g}, not {value!r}")
