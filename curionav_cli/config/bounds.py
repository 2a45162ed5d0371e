"""What the schema checks numbers with."""

from __future__ import annotations


def a_name(key: str, name: str) -> None:
    """Raises ValueError unless it can be part of a folder's name, which the folder of a run is made of."""
    if not name or name.startswith(".") or "/" in name or "\\" in name or not name.isprintable() or len(name) > 100:
        raise ValueError(f"{key}: {name!r} is no name; it may not hold slashes or begin with a dot")


def within(key: str, value: float, least: float = float("-inf"), most: float = float("inf")) -> None:
    """Raises ValueError with 'key: ...' unless least <= value <= most (nan is never within)."""
    if least <= value <= most:
        return
    if most == float("inf"):
        raise ValueError(f"{key}: {value} is less than {least}")
    raise ValueError(f"{key}: {value} is not between {least} and {most}")
