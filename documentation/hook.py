"""MkDocs: pages that lie outside docs/, and links that lead out of it."""

from __future__ import annotations

import posixpath
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[1]
OUTSIDE = ("benchmarks/RESULTS.md", "CHANGELOG.md", "CONTRIBUTING.md")  # they lie at the same path in the site
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")


def on_files(files: Files, config: Any) -> Files:
    """Add the pages outside docs/."""
    for name in OUTSIDE:
        files.append(File.generated(config, name, abs_src_path=str(ROOT / name)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Lead links to where their files are in the site; of a file that the site has not, keep the name."""
    uri = page.file.src_uri
    source = posixpath.join("" if uri in OUTSIDE else "docs", uri)
    return LINK.sub(lambda link: relinked(link, source, uri), markdown)


def relinked(link: re.Match[str], source: str, uri: str) -> str:
    """One link of the file `source` of the checkout, which is `uri` in the site."""
    picture, text, target, anchor = link.groups(default="")
    if "://" in target or target.startswith("mailto:"):
        return link[0]
    there = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
    if there.startswith("docs/"):
        there = there.removeprefix("docs/")
    elif there not in OUTSIDE:
        return f"`{there}`" if text.strip("`") in there else f"{text} (`{there}`)"
    return f"{picture}[{text.removesuffix('.md')}]({posixpath.relpath(there, posixpath.dirname(uri) or '.')}{anchor})"
