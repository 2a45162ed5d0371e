"""Where output goes: a terminal, a file, or a pipe that may be closed at its other end."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from curionav_cli.errors import Unread


class Screen(Console):
    """A console of rich that raises Unread on a closed pipe; rich itself would end the process."""

    def on_broken_pipe(self) -> None:
        raise Unread


def a_console() -> Console:
    """The console for standard output; a file gets lines of 140 characters, and tables as wide as they are."""
    return Screen() if sys.stdout.isatty() else Screen(width=140)


def mute() -> None:
    """Send standard output to nowhere: at exit Python would complain about a closed pipe."""
    with open(os.devnull, "w") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


BROKEN = ("", "options")  # headings of columns whose text may break over lines


def table(columns: tuple[tuple[str, str], ...], rows: Sequence[tuple[str, ...]]) -> Table:
    """A table without lines. columns: each heading, and the side to which its cells are justified."""
    made = Table(box=SIMPLE, pad_edge=False)
    for heading, side in columns:
        made.add_column(heading, justify="right" if side == "right" else "left", no_wrap=heading not in BROKEN)
    for row in rows:
        made.add_row(*(cell.replace("[", "\\[") for cell in row))
    return made
