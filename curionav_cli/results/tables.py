"""Tables: rows of runs as CSV, Markdown and for the terminal."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

Row = dict[str, Any]

# What a person reads: heading, key of the row, how to write it.
COLUMNS = (
    ("env", "env", "{}"), ("agent", "agent", "{}"), ("seed", "seed", "{}"), ("state", "state", "{}"),
    ("steps", "steps", "{:,}"), ("visited", "visited", "{:,}"), ("cells", "cells", "{:,}"),
    ("coverage", "coverage", "{:.1%}"), ("area", "area_under_curve", "{:.3f}"),
    ("to 50 %", "steps_to_50", "{:,}"), ("to 80 %", "steps_to_80", "{:,}"), ("to 90 %", "steps_to_90", "{:,}"),
    ("forward", "forward", "{:.0%}"), ("left", "left", "{:.0%}"), ("right", "right", "{:.0%}"),
    ("cancelled", "cancelled", "{:.0%}"), ("acting", "seconds_acting", "{:.0f} s"),
    ("learning", "seconds_learning", "{:.0f} s"), ("marking", "marking", "{}"), ("of", "denominator", "{}"),
)


def cells(row: Row) -> list[str]:
    """One row as a person reads it; what is not known is a dash."""
    return [form.format(row[key]) if row.get(key) is not None else "-" for _, key, form in COLUMNS]


def meaning(rows: Sequence[Row]) -> str:
    """The line under every table: which marking rule and which denominator it counts by."""
    counted = sorted({(row["marking"], row["denominator"]) for row in rows})
    return "; ".join(f"visited: marked by {rule}, out of {denominator} cells" for rule, denominator in counted)


def markdown(rows: Sequence[Row]) -> str:
    lines = [[heading for heading, _, _ in COLUMNS], ["---"] * len(COLUMNS), *map(cells, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + f"\n\n{meaning(rows)}\n"


def comma_separated(rows: Sequence[Row]) -> str:
    """Tidy CSV with every key, plain numbers."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(key for row in rows for key in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
