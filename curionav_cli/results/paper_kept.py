"""What `curionav paper figures keep=yes` leaves as an earlier call wrote it: rows and pictures of other worlds."""

from __future__ import annotations

import csv
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from curionav_cli.errors import ConfigError
from curionav_cli.results import tables
from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.paper_lengths import APARTMENTS, UNTIL
from curionav_cli.results.tables import Columns, Row


def merged(part: Table, columns: Columns, out: Path, scenes: Collection[str]) -> Table:
    """The table with the rows that its CSV file in `out` has of other worlds than `scenes`, by world.

    columns: all that it may have. Where the file has rows of such a world, it has those alone.
    """
    before = [row for row in read(out / f"{part.name}.csv", columns) if scene_of(row) not in scenes]
    there = {scene_of(row) for row in before}
    rows = sorted([*before, *(row for row in part.rows if scene_of(row) not in there)], key=by_world)
    return Table(part.name, part.title, tables.known(columns, rows), rows)


def read(path: Path, columns: Columns) -> list[Row]:
    """The rows of a CSV file that was written of these columns; none where there is no file.

    Raises ConfigError where it is not such a file.
    """
    try:
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        if any(None in row or not row.get("env") for row in rows):
            raise ValueError("a row names no world")
        forms = {key: form for _, key, form in columns}
        return [{key: number(text, forms.get(key, "{}")) for key, text in row.items()} for row in rows]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, csv.Error) as error:
        raise ConfigError(f"keep: {path} is not a table of curionav paper figures ({error}). Remove it, or name "
                          "another folder with out=DIR.") from error


def number(text: str, form: str) -> Any:
    """A cell of a CSV file, by the form in which its column is written; None where it is empty."""
    if form == "{}" or not text:
        return text or None
    value = float(text)
    return int(value) if form == "{:,}" else value


def scene_of(row: Row) -> str:
    """The world's name without the settings that distinguish it, as in large_lab changes=true."""
    return str(row["env"]).partition(" ")[0]


def by_world(row: Row) -> int:
    """Sort key: the paper's worlds in its order, then others."""
    return [*UNTIL, scene_of(row)].index(scene_of(row))


def pictures(out: Path, made: Sequence[str], scenes: Collection[str]) -> list[str]:
    """Names of pictures in `out` of the paper's worlds other than `scenes`, and of those just made."""
    others = [scene for scene in UNTIL if scene not in scenes]
    if not set(APARTMENTS) & set(scenes):
        others.append("apartments")  # one picture of them all
    begin = tuple(f"{best}{scene}{end}" for scene in others for best in ("", "best_") for end in "._")
    kept = [path.name for path in sorted(out.glob("*.png")) if path.name.startswith(begin)]
    return list(dict.fromkeys([*made, *kept]))


def apartments_line(parts: Sequence[Table], scenes: Collection[str]) -> list[str]:
    """A line where tables have apartments that the one picture of all of them now lacks."""
    drawn = [scene for scene in APARTMENTS if scene in scenes]
    there = {scene_of(row) for part in parts if part.name == "runs" for row in part.rows}
    lacking = [scene for scene in APARTMENTS if scene in there and scene not in drawn]
    return [f"apartments.png shows {', '.join(drawn)} alone, and the tables have {', '.join(lacking)} too: the picture "
            "is drawn of given runs. Name theirs as well."] if drawn and lacking else []
