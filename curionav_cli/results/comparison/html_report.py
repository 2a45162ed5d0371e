"""A comparison as one self-contained HTML page: figures, film, style and script are inside it.

It opens from a disk and on a phone, asks the network for nothing, and its tables sort by a click on a heading.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

import cv2

from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.page import part
from curionav_cli.results.tables import Row, cells

BAD = ("LEFT OUT", "GAP", "WARNING")  # beginnings of lines that are marked
LOSSLESS = [cv2.IMWRITE_WEBP_QUALITY, 101]


class Picture(NamedTuple):
    """A PNG or WebM file and what it shows."""

    path: Path
    caption: str


class Section(NamedTuple):
    """A heading of the page and what stands below it."""

    name: str
    parts: Sequence[str]


def page(title: str, question: str, sections: Sequence[Section]) -> str:
    """Write the whole page; sections without parts are left out."""
    shown = [section for section in sections if section.parts]
    links = " ".join(f'<a href="#{anchor(section.name)}">{escape(section.name)}</a>' for section in shown)
    body = [f'<p class="question">{escape(question)}</p>' if question else "", f"<nav>{links}</nav>"]
    for name, parts in shown:
        body += [f'<h2 id="{anchor(name)}">{escape(name)}</h2>', *parts]
    return Template(part("report.html")).substitute(
        title=escape(title), body="\n".join(body), style=part("style.css"), script=part("sort.js"))


def anchor(name: str) -> str:
    return name.lower().replace(" ", "-")


def commands(lines: Sequence[str]) -> list[str]:
    """Write the commands that reproduce the page."""
    return [f"<pre>{escape(chr(10).join(lines))}</pre>"] if lines else []


def notes(lines: Sequence[str]) -> list[str]:
    """Write a list; what is missing or uncertain stands out."""
    marked = [f'<li class="bad">{escape(line)}</li>' if line.startswith(BAD) else f"<li>{escape(line)}</li>"
              for line in lines]
    return ["<ul>", *marked, "</ul>"] if lines else []


def picture(one: Picture) -> str:
    """Write a figure with its picture or film inside."""
    caption = escape(one.caption)
    if one.path.suffix == ".webm":
        shown = f'<video controls muted loop playsinline src="{inside("video/webm", one.path.read_bytes())}"></video>'
    else:
        shown = f'<img alt="{caption}" src="{inside("image/webp", webp(one.path))}">'
    return f"<figure>{shown}<figcaption>{caption}</figcaption></figure>"


def inside(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{b64encode(data).decode()}"


def webp(png: Path) -> bytes:
    """Encode a PNG as lossless WebP: the same pixels in half the bytes."""
    picture = cv2.imread(str(png), cv2.IMREAD_UNCHANGED)
    assert picture is not None, f"{png} is no picture"
    return cv2.imencode(".webp", picture, LOSSLESS)[1].tobytes()


def table(one: Table) -> str:
    """Write a table that sorts by the plain values; what is not known comes last."""
    sides = ["" if form == "{}" else ' class="number"' for _, _, form in one.columns]
    head = "".join(f'<th scope="col"{side}><button type="button">{escape(heading)}</button></th>'
                   for side, (heading, _, _) in zip(sides, one.columns))
    rows = [row_of(row, one, sides) for row in one.rows]
    return (f'<div class="wide"><table id="{one.name}"><caption>{escape(one.title)}</caption>'
            f"<thead><tr>{head}</tr></thead><tbody>\n{chr(10).join(rows)}\n</tbody></table></div>")


def row_of(row: Row, one: Table, sides: Sequence[str]) -> str:
    values = [plain(row.get(key)) for _, key, _ in one.columns]
    return "<tr>" + "".join(f'<td{side} data-value="{escape(value)}">{escape(text)}</td>'
                            for side, value, text in zip(sides, values, cells(row, one.columns))) + "</tr>"


def plain(value: Any) -> str:
    """Sort key of a cell: a number as such, of an estimate its value."""
    first = value[0] if isinstance(value, tuple) else value
    return "" if first is None else str(first)
