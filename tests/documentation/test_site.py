"""The site: built strictly, complete, and asking nothing of other servers."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
LOADED = {"script": "src", "link": "href", "img": "src", "iframe": "src", "source": "src", "video": "src"}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("material", reason="needs the extra docs")
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", folder],
                          cwd=ROOT, capture_output=True, text=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


class Loads(HTMLParser):
    """What a page loads by itself, without a click."""

    def __init__(self) -> None:
        super().__init__()
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        if tag in LOADED and found.get("rel") not in ("canonical", "next", "prev"):
            self.addresses.append(found.get(LOADED[tag]) or "")


def test_no_page_loads_anything_from_elsewhere(site: Path) -> None:
    pages = list(site.rglob("*.html"))
    for page in pages:
        loads = Loads()
        loads.feed(page.read_text(encoding="utf-8"))
        assert [one for one in loads.addresses if re.match(r"(\w+:)?//", one)] == [], page
    assert len(pages) > 40


def test_links_out_of_the_docs_lead_to_pages_of_the_site(site: Path) -> None:
    index, code = ((site / name).read_text(encoding="utf-8") for name in ("index.html", "options.html"))
    for name in ("benchmarks/RESULTS.html", "CHANGELOG.html", "CONTRIBUTING.html"):
        assert f'href="{name}"' in index and (site / name).is_file()
    assert "<code>curionav_cli/options.py</code>" in code and "../curionav_cli" not in code


def test_the_way_through_the_site_is_that_of_a_newcomer() -> None:
    text = re.sub(r"!!python/\S+", "", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"))
    titles = [next(iter(part)) for part in yaml.safe_load(text)["nav"]]
    assert titles == ["Start here", "Install", "First run", "Your own map", "Your own agent", "The robot",
                      "Sweeps and clusters", "Remote training", "Results", "The paper", "Reference", "History"]


@pytest.mark.skipif(shutil.which("git") is None or not (ROOT / ".git").exists(), reason="needs a checkout")
def test_the_built_site_is_not_committed() -> None:
    assert subprocess.run(["git", "check-ignore", "-q", "site/index.html"], cwd=ROOT).returncode == 0
