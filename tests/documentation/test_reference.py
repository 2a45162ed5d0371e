"""The reference pages are what the schema and the command line say today, and every setting is explained."""

from __future__ import annotations

import pytest

from curionav_cli.bounds import noted, within
from documentation import commands_page, settings_page, settings_rows
from documentation.pages import PAGES, ROOT


@pytest.mark.parametrize("name", PAGES)
def test_the_page_is_up_to_date(name: str) -> None:
    assert (ROOT / name).read_text(encoding="utf-8") == PAGES[name](), "type: make docs"


def test_every_setting_of_every_option_has_a_row() -> None:
    page = settings_page.page()
    keys = {key for _, found in settings_rows.compositions() for key in found}
    assert len(keys) > 200 and [key for key in keys if f"| `{key}` |" not in page] == []


def test_no_line_explains_a_setting_that_is_gone() -> None:
    keys = {key for _, found in settings_rows.compositions() for key in found}
    named = {key for key in settings_rows.meanings() if "*" not in key and not key.startswith("hydra.")}
    assert named - keys == set()


def test_every_number_has_its_range() -> None:
    numbers = {key: one for _, found in settings_rows.compositions() for key, one in found.items()
               if "number" in one.kind and "list" not in one.kind}
    assert [key for key, one in numbers.items() if one.range is None] == []
    assert numbers["loop.steps"].limits == "1 to 1000000" and numbers["env.cell"].limits == "0.01 to 2"


def test_a_setting_without_a_line_is_named() -> None:
    with pytest.raises(LookupError, match=r"agent\.new has no meaning: give it a line in meanings\.yaml"):
        settings_rows.meaning("agent.new")


def test_ranges_are_noted_while_somebody_asks() -> None:
    with noted() as ranges:
        within("a.b", 2.0, least=1, most=3)
    within("a.c", 2.0, least=1, most=3)
    assert ranges == {"a.b": (1, 3)}


def test_the_commands_of_the_page_are_those_of_the_command_line() -> None:
    page = commands_page.page()
    for words in ("## curionav explore", "## curionav robot check", "`-m`, `--multirun`", "`landing`, `swept`"):
        assert words in page
