"""Blocks of a Markdown page that a command writes; the rest of the page is its author's.

A block begins with a line such as <!-- curionav paper figures: verdicts --> and ends with the line <!-- end -->.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

from curionav_cli.errors import ConfigError
from curionav_cli.files import write_whole

MARK = "<!-- curionav paper {}: {} -->"
END = "<!-- end -->"
BLOCK = re.compile(rf"^{MARK.format('([a-z]+)', '([a-z_]+)')}\n(.*?)^{END}$", re.MULTILINE | re.DOTALL)
BEGINNING = re.compile(rf"^{MARK.format('.*', '.*')}$", re.MULTILINE)

Blocks = Mapping[tuple[str, str], str]  # (what is written, such as figures; its name) -> text


def block(what: str, name: str, text: str = "") -> str:
    """A block with its marks, and empty lines around its text, so that a table in it is one."""
    return "\n".join([MARK.format(what, name), *(["", text.strip("\n"), ""] if text.strip() else []), END])


def blocks(page: str) -> Blocks:
    """The text in each block of a page."""
    return {(what, name): text for what, name, text in BLOCK.findall(page)}


def filled(page: str, new: Blocks) -> str:
    """The page with these texts in its blocks; blocks of other names stay as they are."""
    return BLOCK.sub(lambda found: block(found[1], found[2], new.get((found[1], found[2]), found[3])), page)


def opened(path: Path, what: str, names: Sequence[str]) -> str:
    """The page at `path`, into which `what` is to be written. Raises ConfigError where it has no block for it
    or may not be written.

    names: those that its blocks may have.
    """
    try:
        page = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"page: {path} cannot be read ({getattr(error, 'strerror', None) or 'it is not UTF-8'}). "
                          "Name a Markdown page.") from error
    if not all(os.access(place, os.W_OK) for place in (path, path.resolve().parent)):
        raise ConfigError(f"page: {path} may not be written. Make it and its folder writable (chmod u+w), or name "
                          "another.")
    found = [name for kind, name in blocks(page) if kind == what]
    wrong = [name for name in found if name not in names]
    whole = len(BLOCK.findall(page)) == len(BEGINNING.findall(page))
    if not found or wrong or not whole:
        why = "has a block without an end" if not whole else f"has a block {wrong[0]}" if wrong else "has no block"
        raise ConfigError(f"page: {path} {why}. What curionav paper {what} writes stands between a line "
                          f"{MARK.format(what, names[0])} and a line {END}; names are {', '.join(names)}.")
    return page


def written(path: Path, text: str) -> None:
    """Write the page where it is, also behind a link, with the permissions that it has."""
    page = path.resolve()
    mode = page.stat().st_mode

    def body(file: IO[bytes]) -> None:
        file.write(text.encode())
        os.fchmod(file.fileno(), mode)
    write_whole(page, body)
