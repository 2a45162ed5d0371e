"""What `curionav paper figures` and `curionav paper changes` write into pages: tables and pictures of runs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from curionav_cli.results import tables
from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.page_blocks import Blocks, block

NAMES = {  # of blocks
    "figures": ("verdicts", "against", "arms", "coverage", "runs", "pictures", "command"),
    "changes": ("change_pairs", "change_ages", "changes", "surprise_by_age", "pictures", "command")}
NOT_SHOWN = ("folder", "rule")  # columns that a page goes without
SHOWN = {  # by the longest beginning of a picture's name
    "apartments": "Cells visited in the apartments over the paper's steps, a to d",
    "small_room": "The paper's figure of the small room: heatmap, run 1 and run 2",
    "small_room_arms": "Cells visited in the small room over the paper's steps",
    "large_lab": "The paper's figure of the lab: heatmap and curve",
    "large_lab_arms": "Cells visited in the lab over the paper's steps",
    "best": "Heatmap of the best run of each arm",
    "changes": "Coverage, share of steps near what just moved, and surprise there"}
SECTION = (
    "## At the paper's lengths\n\n"
    "The paper's claims by the rules of docs/paper-length.md, which were declared before the runs. "
    "`curionav paper figures RUN... page=PAGE` writes what follows; `curionav paper numbers` leaves it as it is.\n\n"
    + "\n\n".join(block("figures", name) for name in ("command", "verdicts", "pictures")) + "\n")


def blocks(what: str, command: str, parts: Sequence[Table], drawn: str) -> Blocks:
    """The text of each block. what: figures or changes; command: the line that was typed; drawn: links to pictures."""
    made = {part.name: table(part) for part in parts} | {"pictures": drawn, "command": f"Written by `{command}`."}
    return {(what, name): made.get(name, "No run yet.") for name in NAMES[what]}


def table(part: Table) -> str:
    """A table of a page."""
    columns = [column for column in tables.known(part.columns, part.rows) if column[1] not in NOT_SHOWN]
    return tables.markdown(part.rows, columns, part.title)


def pictures(names: Sequence[str], out: Path, beside: Path) -> str:
    """Links from a page in the folder `beside` to pictures in the folder `out`."""
    return "\n\n".join(f"![{shown(name)}]({Path(os.path.relpath(out, beside), name).as_posix()})" for name in names)


def shown(name: str) -> str:
    """What a picture of this name shows."""
    key = max((key for key in SHOWN if name.startswith(key)), key=len)
    return ", ".join(filter(None, [SHOWN[key], name.removesuffix(".png").removeprefix(key).strip("_")]))
