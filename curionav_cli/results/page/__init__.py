"""Parts of the HTML pages: report.html, which compare writes, and the page of watch share style and sorting."""

from __future__ import annotations

from pathlib import Path


def part(name: str) -> str:
    """The text of a part, such as style.css."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")
