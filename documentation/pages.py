"""The generated pages by their path in the checkout."""

from __future__ import annotations

from pathlib import Path

from documentation import commands_page, settings_page

ROOT = Path(__file__).resolve().parents[1]
PAGES = {
    "docs/reference/settings.md": settings_page.page,
    "docs/reference/commands.md": commands_page.page,
}


def write() -> list[Path]:
    """Write every page that differs from what stands there; returns those that were written."""
    written = []
    for name, make in PAGES.items():
        path, text = ROOT / name, make()
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            written.append(path)
    return written
