"""The page of a comparison: whole, escaped, and in a real browser quiet, sortable and narrow enough for a phone."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from curionav_cli.results import film
from curionav_cli.results.comparison import html_report
from curionav_cli.results.comparison.html_report import Picture, Section
from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.statistics import Estimate

ROWS = [{"arm": "b", "area": Estimate(0.25, 0.2, 0.3), "left": "<script>alert(1)</script>"},
        {"arm": "a", "area": Estimate(10.0, 9.0, 11.0), "left": "& more"}, {"arm": "c", "area": None, "left": ""}]
COLUMNS = (("arm", "arm", "{}"), ("area", "area", "{:.2f}"), ("left out", "left", "{}"))


@pytest.fixture
def page(tmp_path: Path) -> Path:
    cv2.imwrite(str(tmp_path / "one.png"), np.full((20, 900, 3), 200, np.uint8))
    film.write((np.full((64, 64, 3), grey, np.uint8) for grey in range(0, 200, 20)), tmp_path / "two.webm")
    pictures = [html_report.picture(Picture(tmp_path / name, name)) for name in ("one.png", "two.webm")]
    text = html_report.page("A <b> title", "Does it & beat?", [
        Section("What to know", html_report.notes(["LEFT OUT: a run", "all else is well"])), Section("Nothing", []),
        Section("Figures", pictures),
        Section("Tables", [html_report.table(Table("arms", "What <they> did", COLUMNS, ROWS))]),
        Section("Made by", html_report.commands(["curionav compare 'a b'"]))])
    (tmp_path / "report.html").write_text(text)
    return tmp_path / "report.html"


class Seen(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in ("meta", "link", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_is_whole_and_asks_for_nothing(page: Path) -> None:
    seen = Seen()
    seen.feed(page.read_text())
    assert not seen.open
    asked = [value for _, attributes in seen.tags for key, value in attributes.items() if key in ("src", "href")]
    assert len(asked) == 7 and all(one and one.startswith(("data:", "#")) for one in asked)
    assert [tag for tag, _ in seen.tags].count("script") == 1
    assert "Nothing" not in page.read_text()


def test_a_cell_is_sorted_by_its_plain_value() -> None:
    assert html_report.plain(Estimate(0.25, 0.2,
                                      0.3)) == "0.25" and html_report.plain(None) == "" and html_report.plain(3) == "3"


def opened(browser: Any, page: Path) -> tuple[Any, list[str], list[str]]:
    """The page as a phone shows it, what its console said, and what it asked for."""
    shown = browser.new_page(viewport={"width": 390, "height": 844})
    said: list[str] = []
    asked: list[str] = []
    shown.on("console", lambda message: said.append(message.text))
    shown.on("pageerror", lambda error: said.append(str(error)))
    shown.on("request", lambda request: asked.append(request.url))
    shown.goto(page.as_uri())
    shown.wait_for_function("document.querySelector('video').readyState > 0"
                            " && [...document.images].every(image => image.complete)")
    return shown, said, asked


@pytest.mark.browser
def test_the_page_that_compare_wrote_of_the_comparison_in_docs(browser: Any) -> None:
    page = Path(__file__).parents[3] / "docs" / "comparison" / "report.html"
    shown, said, asked = opened(browser, page)
    assert shown.evaluate("document.documentElement.scrollWidth") == 390
    assert shown.evaluate("Math.min(...[...document.images].map(image => image.naturalWidth))") > 500
    tables = shown.evaluate("[...document.querySelectorAll('table')].map(table => table.id)")
    assert {"arms", "pairs", "runs"} <= set(tables)
    shown.locator("#runs").get_by_role("button", name="area").click()
    areas = shown.evaluate("[...document.querySelectorAll('#runs tbody tr')].map(row => row.cells[5].dataset.value)")
    assert len(areas) == 80 and [float(area) for area in areas] == sorted(float(area) for area in areas)
    assert not said and [url for url in asked if not url.startswith("data:")] == [page.as_uri()]


@pytest.mark.browser
def test_in_a_browser_it_is_quiet_sortable_and_narrow(page: Path, browser: Any) -> None:
    shown, said, asked = opened(browser, page)
    assert shown.evaluate("[document.images[0].naturalWidth, document.querySelector('video').videoWidth]") == [900, 64]
    assert shown.evaluate("document.documentElement.scrollWidth") == 390
    order = "[...document.querySelectorAll('#arms tbody tr')].map(row => row.cells[0].innerText).join('')"
    button = shown.get_by_role("button", name="area")
    for wanted in ("bac", "abc"):  # smallest first, then largest first; what is not known stays last
        button.click()
        assert shown.evaluate(order) == wanted
    shown.get_by_role("button", name="arm").click()
    assert shown.evaluate(order) == "abc" and shown.evaluate("document.title") == "A <b> title"
    assert not said and [url for url in asked if not url.startswith("data:")] == [page.as_uri()]
