"""docs/troubleshooting.md quotes messages that the code has: what varies is written as an ellipsis."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

import pytest

import curionav_cli

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "troubleshooting.md"
PACKAGE = Path(curionav_cli.__file__).parent
VARIES = "\N{HORIZONTAL ELLIPSIS}"


@cache
def literals() -> tuple[str, ...]:
    """Every text in the code but docstrings, an ellipsis where something is formatted into it; names of classes too."""
    found = set()
    for path in PACKAGE.rglob("*.py"):
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        for node in (node for node in nodes if id(node) not in docstrings):
            if isinstance(node, ast.JoinedStr):
                parts = (part.value if isinstance(part, ast.Constant) else VARIES for part in node.values)
                found.add("".join(map(str, parts)))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                found.add(node.value)
            elif isinstance(node, ast.ClassDef):
                found.add(node.name)
    return tuple(found)


def messages() -> list[str]:
    """What stands in ticks in the first column of the tables behind the one of exit codes."""
    tables = PAGE.read_text(encoding="utf-8").partition("## Typing")[2].partition("## No message")[0]
    return re.findall(r"^\| `([^`]+)` \|", tables, re.MULTILINE)


def said(message: str) -> bool:
    """Whether some text of the code has the fixed parts of a message, in their order."""
    fixed = [re.escape(part.strip()) for part in message.split(VARIES) if part.strip()]
    pattern = re.compile(".*".join(fixed), re.DOTALL)
    return any(pattern.search(text) for text in literals())


def test_a_message_that_the_code_has_not_would_be_seen() -> None:
    assert said(f"{VARIES} is in use by {VARIES}. Wait for it, or stop it.")
    assert not said(f"{VARIES} is in use by {VARIES}. Wait for her.") and not said("No such sentence at all.")


def test_the_page_quotes_messages_from_every_part_of_the_product() -> None:
    assert len(messages()) == len(set(messages())) > 50


@pytest.mark.parametrize("message", messages())
def test_every_quoted_message_is_in_the_code(message: str) -> None:
    assert said(message)
