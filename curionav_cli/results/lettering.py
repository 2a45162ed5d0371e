"""Text in figures: wrapped to the width there is, and without letters that the font cannot draw."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from textwrap import wrap

from matplotlib.figure import Figure
from matplotlib.font_manager import findfont, get_font
from matplotlib.text import Text

LETTER, LINE = 0.074, 0.16  # inches, of a letter and of a line at 9 points; capitals are wider


def wrapped(text: str, inches: float, indent: str = "") -> str:
    """Wrap a text to this width in inches; words are broken where they must be."""
    wide = max(8, int(inches / LETTER))
    return "\n".join(part for line in text.split("\n")
                     for part in wrap(line, wide, subsequent_indent=indent) or [""])


def columns_for(figure: Figure, names: Sequence[str], most: int = 5, share: float = 1.0) -> int:
    """Number of a legend's columns that fit into a share of the figure's width."""
    wide = max((len(line) for name in names for line in name.split("\n")), default=1) * LETTER + 0.55
    return max(1, min(most, len(names), int(share * figure.get_figwidth() / wide)))


def legible(text: str) -> str:
    """The text with \\uXXXX for what the figures' own font lacks: the same on every machine."""
    return "".join(letter if letter == "\n" or drawable(letter) else ascii(letter)[1:-1] for letter in text)


@cache
def drawable(letter: str) -> bool:
    return get_font(findfont("DejaVu Sans")).get_char_index(ord(letter)) != 0


def settle(figure: Figure) -> None:
    """Make every text of a figure legible."""
    for text in figure.findobj(Text):
        text.set_text(legible(text.get_text()))
