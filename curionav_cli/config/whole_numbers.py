"""Whole numbers in any spelling, such as 1e3 and 500.0, on the command line, in a file or in a sweep."""

from __future__ import annotations

from typing import Any

from omegaconf import IntegerNode
from omegaconf.errors import ValidationError

EXACT = 2**53  # beyond it a float is no longer one whole number


class WholeNumber(IntegerNode):
    """An integer node of OmegaConf that also takes 1e3 and 500.0. Raises ValidationError for 1.5."""

    def _validate_and_convert_impl(self, value: Any) -> int:
        try:
            return super()._validate_and_convert_impl(value)
        except ValidationError:
            number = as_float(value)
            if isinstance(value, bool) or not number.is_integer() or abs(number) > EXACT:
                raise
            return int(number)

    def __deepcopy__(self, memo: dict[int, Any]) -> WholeNumber:
        node = WholeNumber()
        self._deepcopy_impl(node, memo)
        return node


def as_float(value: Any) -> float:
    """The value as a float; nan for what is no number."""
    try:
        return float(value)
    except (TypeError, ValueError):
        return float("nan")


def take_any_spelling(node: Any) -> None:
    """Let an integer node of a schema take any spelling; other nodes stay as they are."""
    if type(node) is IntegerNode:
        node.__class__ = WholeNumber
