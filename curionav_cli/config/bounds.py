"""What the schema checks numbers with."""

from __future__ import annotations


def within(key: str, value: float, least: float = float("-inf"), most: float = float("inf")) -> None:
    """Raises ValueError with 'key: ...' unless least <= value <= most (nan is never within)."""
    if least <= value <= most:
        return
    if most == float("inf"):
        raise ValueError(f"{key}: {value} is less than {least}")
    raise ValueError(f"{key}: {value} is not between {least} and {most}")
