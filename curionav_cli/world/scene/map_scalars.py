"""Numbers and truth values as yaml-cpp reads them, which is what Nav2 reads its maps with.

A YAML scalar is text first, quoted or not; what it means is asked afterwards. So 010 is ten as a float and eight as an
int, and "0", off and N are false. https://github.com/jbeder/yaml-cpp (0.8.0, node/convert.h and src/convert.cpp)
"""

from __future__ import annotations

import re

_FLOAT = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*", re.ASCII)
_ENDLESS = re.compile(r"[+-]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_INT = re.compile(r"([+-]?)(?:0[xX]([0-9a-fA-F]+)|(0[0-7]*)|([1-9]\d*))\s*", re.ASCII)
_INT_RANGE = range(-2**31, 2**31)
_BOOLS = {form: truth for words, truth in ((("y", "yes", "true", "on"), True), (("n", "no", "false", "off"), False))
          for word in words for form in (word, word.upper(), word.capitalize())}


def as_float(text: str) -> float:
    """Read a float: 1e-05, 5., .5, 010 (ten), .inf, .nan. Raises ValueError for anything else, and for an overflow."""
    if _ENDLESS.fullmatch(text):
        return float(text.replace(".", ""))
    number = float(text) if _FLOAT.fullmatch(text) else float("inf")
    if number in (float("inf"), float("-inf")):
        raise ValueError(f"{text!r} is no number")
    return number


def as_int(text: str) -> int:
    """Read an integer of 32 bits: 12, 0x0c, 014 (octal). Raises ValueError for anything else."""
    found = _INT.fullmatch(text)
    if found is None:
        raise ValueError(f"{text!r} is no whole number")
    sign, *digits = found.groups()
    number = next(int(part, base) for part, base in zip(digits, (16, 8, 10), strict=True) if part)
    number = -number if sign == "-" else number
    if number not in _INT_RANGE:
        raise ValueError(f"{text!r} has more than 32 bits")
    return number


def as_bool(text: str) -> bool:
    """Read a truth value: y, yes, true, on, n, no, false, off, also capitalised or in capitals. Raises ValueError."""
    if text not in _BOOLS:
        raise ValueError(f"{text!r} is neither true nor false")
    return _BOOLS[text]
