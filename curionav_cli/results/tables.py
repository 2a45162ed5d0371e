"""Tables: rows of runs as CSV, Markdown and for the terminal."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from typing import Any

import numpy as np

Row = dict[str, Any]
Columns = Sequence[tuple[str, str, str]]

# What a person reads: heading, key of the row, how to write it.
COLUMNS: Columns = (
    ("env", "env", "{}"), ("agent", "agent", "{}"), ("seed", "seed", "{}"), ("state", "state", "{}"),
    ("steps", "steps", "{:,}"), ("visited", "visited", "{:,}"), ("cells", "cells", "{:,}"),
    ("coverage", "coverage", "{:.1%}"), ("area", "area_under_curve", "{:.3f}"),
    ("to 50 %", "steps_to_50", "{:,}"), ("to 80 %", "steps_to_80", "{:,}"), ("to 90 %", "steps_to_90", "{:,}"),
    ("to 99 %", "steps_to_99", "{:,}"), ("explored", "steps_to_explored", "{:,}"),
    ("forward", "forward", "{:.0%}"), ("left", "left", "{:.0%}"), ("right", "right", "{:.0%}"),
    ("cancelled", "cancelled", "{:.0%}"), ("acting", "seconds_acting", "{:.0f} s"),
    ("learning", "seconds_learning", "{:.0f} s"), ("CPU", "cpu_seconds", "{:.0f} s"),
    ("memory", "memory", "{:.2f} GB"), ("updates", "updates", "{:,.0f}"),
    ("frames read", "frames_read", "{:,.0f}"), ("marking", "marking", "{}"), ("of", "denominator", "{}"),
)

PROBED: Columns = (("probe error", "probe_error", "{:.4f}"), ("surprise", "probe_surprise", "{:.2f}"))


def columns_of(rows: Sequence[Row]) -> Columns:
    """The columns that a person reads, those of probes only where a row has them."""
    return (*COLUMNS, *(PROBED if any("probe_error" in row for row in rows) else ()))


def known(columns: Columns, rows: Sequence[Row]) -> Columns:
    """Those of the columns that a row knows something about."""
    return tuple(column for column in columns if any(row.get(column[1]) is not None for row in rows))


def percent(share: float) -> str:
    """Write a share as '45.4%'; never 0.0% of something, nor 100.0% of less than all (263 of 700,000 are 0.038%)."""
    if 0 < share < 0.0005:
        return f"{np.format_float_positional(100 * share, 2, fractional=False, trim='-')}%"
    return f"{min(share, 0.999) if share < 1 else share:.1%}"


def covered(share: float | None, visited: int, total: int | None, what: str = "") -> str:
    """Write a coverage as '45.4% of 449 cells', or '63 cells of an unknown number' of a real floor without a map."""
    if share is None or total is None:
        return f"{visited:,} cells of an unknown number"
    return f"{percent(share)} of {total:,}{f' {what}' * bool(what)} cells"


def written(form: str, value: Any) -> str:
    """Write a value in a column's form; shares as `percent` does."""
    return percent(value) if form == "{:.1%}" and isinstance(value, float) else form.format(value)


def cells(row: Row, columns: Columns = COLUMNS) -> list[str]:
    """Write one row as a person reads it; what is not known is a dash."""
    return [written(form, row[key]) if row.get(key) is not None else "-" for _, key, form in columns]


def meaning(rows: Sequence[Row]) -> str:
    """Name the marking rules and denominators of these rows: the line under every table."""
    counted = sorted({(row["marking"], row["denominator"] if row["cells"] or row["visited"] is None else "",
                       row.get("pose", "")) for row in rows})
    return "; ".join(counted_by(*one) for one in counted)


def counted_by(rule: str, denominator: str, pose: str = "") -> str:
    by = f"{rule}, by the {pose} pose" if pose else rule
    return f"visited: marked by {by}, out of {denominator or 'an unknown number of'} cells"


def markdown(rows: Sequence[Row], columns: Columns = (), below: str = "") -> str:
    """Write a Markdown table. columns: those of runs by default; below: the line under it, or how visits are counted.
    """
    columns = columns or columns_of(rows)
    lines = [[heading for heading, _, _ in columns], ["---"] * len(columns), *(cells(row, columns) for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + f"\n\n{below or meaning(rows)}\n"


def latex(rows: Sequence[Row], columns: Columns, caption: str) -> str:
    """Write a LaTeX table for booktabs: numbers to the right, words to the left."""
    body = [cells(row, columns) for row in rows]
    sides = "".join("l" if form == "{}" else "r" for _, _, form in columns)
    lines = ["\\begin{table}", "\\centering", f"\\caption{{{escaped(caption)}}}", f"\\begin{{tabular}}{{{sides}}}",
             "\\toprule", tex_line([heading for heading, _, _ in columns]), "\\midrule", *map(tex_line, body),
             "\\bottomrule", "\\end{tabular}", "\\end{table}"]
    return "\n".join(lines) + "\n"


def tex_line(words: Sequence[str]) -> str:
    return " & ".join(map(escaped, words)) + r" \\"


def escaped(text: str) -> str:
    """Escape plain text for LaTeX; backslash, caret and tilde become a dash."""
    return re.sub(r"[&%$#_{}]", r"\\\g<0>", re.sub(r"[\\^~]", "-", text))


def comma_separated(rows: Sequence[Row]) -> str:
    """Write tidy CSV with every key and plain numbers; bounds of an estimate as KEY_low and KEY_high."""
    tidy = [spread(row) for row in rows]
    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(key for row in tidy for key in row)), lineterminator="\n")
    writer.writeheader()
    writer.writerows(tidy)
    return text.getvalue()


def spread(row: Row) -> Row:
    """Split a named tuple in a cell into a cell for each part, the first under the row's own key."""
    found: Row = {}
    for key, value in row.items():
        parts = list(value._asdict().items()) if hasattr(value, "_asdict") else []
        found |= {key: parts[0][1], **{f"{key}_{name}": part for name, part in parts[1:]}} if parts else {key: value}
    return found
