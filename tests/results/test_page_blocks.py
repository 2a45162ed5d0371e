"""Blocks of a page: written anew, and nothing else of it; a page without them, or with a broken one, is refused."""

from pathlib import Path

import pytest

from curionav_cli.errors import ConfigError
from curionav_cli.results import page_blocks, paper_page
from curionav_cli.results.comparison.tables import Table

OTHERS = page_blocks.block("changes", "changes", "old")
PAGE = f"# Mine\n\n{page_blocks.block('figures', 'runs')}\n\nMy words.\n\n{OTHERS}\n"


def test_a_block_is_written_anew_and_again_and_the_rest_stays() -> None:
    once = page_blocks.filled(PAGE, {("figures", "runs"): "| a |\n| --- |\n"})
    assert once == PAGE.replace("figures: runs -->\n", "figures: runs -->\n\n| a |\n| --- |\n\n")
    assert page_blocks.blocks(once)["figures", "runs"] == "\n| a |\n| --- |\n\n"
    assert page_blocks.filled(once, page_blocks.blocks(once)) == once
    assert page_blocks.filled(once, {("figures", "runs"): r"\1 | b"}).count(r"\1 | b") == 1


@pytest.mark.parametrize(("text", "said"), [
    ("# Mine\n", "has no block"), (OTHERS, "has no block"),
    (page_blocks.block("figures", "verdict"), "has a block verdict. "),
    (PAGE.replace("changes: changes", "figures: arms").removesuffix("<!-- end -->\n"), "a block without an end"),
    (b"\xff\xfe", "not UTF-8"), (None, "No such file"),
])
def test_a_page_that_cannot_be_written_into_is_named(tmp_path: Path, text: str | bytes | None, said: str) -> None:
    page = tmp_path / "page.md"
    if text is not None:
        page.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ConfigError, match=said) as refused:
        page_blocks.opened(page, "figures", paper_page.NAMES["figures"])
    assert str(page) in str(refused.value)


def test_a_page_behind_a_link_keeps_its_link_and_its_permissions(tmp_path: Path) -> None:
    (page := tmp_path / "page.md").write_text("old")
    page.chmod(0o640)
    (link := tmp_path / "link.md").symlink_to(page.name)
    page_blocks.written(link, "new")
    assert link.is_symlink() and (page.read_text(), page.stat().st_mode & 0o777) == ("new", 0o640)
    assert sorted(tmp_path.iterdir()) == [link, page]


def test_a_page_that_is_read_only_is_refused_before_anything_is_read(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (page := tmp_path / "page.md").write_text(PAGE)
    monkeypatch.setattr(page_blocks.os, "access", lambda path, mode: False)  # root may write everything
    with pytest.raises(ConfigError, match=r"page\.md may not be written\. Make it and its folder writable"):
        page_blocks.opened(page, "figures", paper_page.NAMES["figures"])


def test_a_page_has_no_folders_and_links_beside_itself(tmp_path: Path) -> None:
    part = Table("runs", "One row a run.", (("arm", "arm", "{}"), ("folder", "folder", "{}")),
                 [{"arm": "bounce", "folder": "/somewhere"}])
    drawn = paper_page.pictures(["best_small_room.png", "small_room_arms.png"], tmp_path / "out" / "length", tmp_path)
    found = paper_page.blocks("figures", "curionav paper figures runs", [part], drawn)
    assert found["figures", "runs"] == "| arm |\n| --- |\n| bounce |\n\nOne row a run.\n"
    assert found["figures", "verdicts"] == "No run yet."
    assert found["figures", "command"] == "Written by `curionav paper figures runs`."
    assert "![Heatmap of the best run of each arm, small_room](out/length/best_small_room.png)" in drawn
    assert "![Cells visited in the small room over the paper's steps](out/length/small_room_arms.png)" in drawn
