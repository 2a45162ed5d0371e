"""The documentation: links resolve, the index leads everywhere, and commands are such as the command line accepts."""

from __future__ import annotations

import re
import shlex
import shutil
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from entry import Cli
from office import write_two_rooms

from curionav_cli.commands import compare, coverage, doctor, init, listing, paper, resume, robot, runs
from curionav_cli.commands import map as map_command
from curionav_cli.commands.arguments import one_of, sorted_out
from curionav_cli.config import compose
from curionav_cli.config.settings import settings_yaml
from curionav_cli.execution import launch
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scan.export import export
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

ROOT = Path(__file__).resolve().parents[1]
INDEX = ROOT / "docs" / "index.md"
DOCS = sorted((ROOT / "docs").rglob("*.md"))
PAGES = [ROOT / "README.md", *DOCS]
TYPED = ("README.md", "docs/index.md", "docs/run-folder.md", "docs/maps.md", "docs/evaluate.md")
FENCE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def prose(page: Path) -> str:
    """The page without its fenced blocks."""
    return FENCE.sub("", page.read_text(encoding="utf-8"))


def links(page: Path) -> Iterator[tuple[str, Path, str]]:
    """Every relative link of a page: as it is written, the file, the anchor."""
    for link in LINK.findall(prose(page)):
        if "://" not in link:
            name, _, anchor = link.partition("#")
            yield link, (page.parent / name).resolve() if name else page, anchor


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub names them."""
    found: Counter[str] = Counter()
    names = set()
    for heading in re.findall(r"^#+ (.+)$", prose(page), re.MULTILINE):
        name = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        names.add(f"{name}-{found[name]}" if found[name] else name)
        found[name] += 1
    return names


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_to_a_file_and_a_heading(page: Path) -> None:
    for link, file, anchor in links(page):
        assert file.exists() and file.is_relative_to(ROOT), link
        assert not anchor or anchor in anchors(file), link


def test_the_index_leads_to_every_page_in_two_clicks() -> None:
    first = {file for _, file, _ in links(INDEX)}
    second = {file for page in first if page.suffix == ".md" for _, file, _ in links(page)}
    assert set(DOCS) <= {INDEX} | first | second


def commands(page: Path) -> Iterator[list[str]]:
    """The words behind `curionav` of every command in a page's blocks and inline code."""
    text = page.read_text(encoding="utf-8")
    lines = [line for block in FENCE.findall(text) for line in block.splitlines()]
    inline = re.findall(r"`([^`\n]+)`", FENCE.sub("", text))
    for line in [*lines, *inline]:
        if line.startswith("curionav "):
            yield shlex.split(line, comments=True)[1:]


@pytest.fixture
def typed(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, an_episode, a_plan) -> Cli:
    """The entry point up to the moment when something would run, beside a map, a scan and the runs that pages name."""
    write_two_rooms(tmp_path)
    export(Scene.from_dict(*plain("small_room")), tmp_path / "flat.glb")
    run = RunFolder(tmp_path / "outputs" / "DATE" / "RUN")
    run.create(settings_yaml(compose.composed("explore")), {"env": {"name": "small_room"}}, {}, a_plan())
    run.save_episode(0, replace(an_episode(steps=100), action=np.zeros(100, np.int64)))  # actions are held
    (run.checkpoints / "000001").mkdir(parents=True)
    (run.checkpoints / "000001" / "done").touch()
    for name in ("0_small_room_lbs_dreamer_0", "1_small_room_lbs_dreamer_1"):
        shutil.copytree(run.path, tmp_path / "outputs" / "DATE" / "SWEEP" / name)
    monkeypatch.setattr(launch, "run_plan", lambda *_: 0)
    monkeypatch.setattr(compose, "COMPOSED", 1)  # of a sweep each value once
    for name, module in {"coverage": coverage, "compare": compare, "runs": runs, "paper": paper,
                         "map": map_command}.items():
        monkeypatch.setattr(module, "run", lambda words, name=name, module=module: accepted(name, module, words))
    monkeypatch.setattr(resume, "run", resumable)
    monkeypatch.setattr(robot, "check", lambda profile, words, move: robot.settings_of(profile, words) and 0)
    monkeypatch.setattr(listing, "run", lambda group, config_dir: one_of("list", group, launch_groups()) and 0)
    monkeypatch.setattr(doctor, "run", lambda: 0)
    monkeypatch.setattr(init, "run", lambda folder: 0)
    return cli


def accepted(name: str, module, words: Sequence[str]) -> int:
    """Whether words of a command that reads run folders are such as it takes, and the folders are there."""
    folders, _ = sorted_out(name, words, module.CHOICES)
    if name == "paper":
        one_of(name, str(folders.pop(0)), module.WHAT)
    assert all(folder.is_dir() for folder in folders), words
    return 0


def resumable(folder: Path, changes: Sequence[str], failed: bool) -> int:
    """Whether a run of `curionav explore` may be resumed with these changes."""
    for change in changes:
        one_of("resume", change.partition("=")[0], resume.MAY_CHANGE["explore"])
    assert folder.is_dir(), folder
    return 0


def launch_groups() -> tuple[str, ...]:
    return tuple(path.name for path in (ROOT / "conf").iterdir() if path.is_dir())


@pytest.mark.parametrize("page", TYPED)
def test_every_command_of_a_page_passes_the_pre_flight(typed: Cli, tmp_path: Path, page: str) -> None:
    found = list(commands(ROOT / page))
    refused = {}
    for words in found:
        if len(words) == 1 and not words[0].startswith("-"):
            words = [*words, "--help"]  # named, not typed
        elif words == ["--install-completion"]:
            words = ["--help"]
        made_up = [word.replace("URL", f"file://{tmp_path}/store").removesuffix("...") for word in words]
        answer = typed(*made_up)
        if answer.code:
            refused[shlex.join(words)] = answer.error
    assert found and refused == {}


def test_the_page_of_the_papers_numbers_has_the_sentences_of_its_command() -> None:
    page = (ROOT / "docs" / "paper-vs-ours.md").read_text(encoding="utf-8")
    about = paper.page("COMMAND", [], []).splitlines()
    assert [line for line in about if "COMMAND" not in line and line not in page.splitlines()] == []
    assert [title for title in paper.TITLES.values() if title not in page] == []
    assert paper.page("COMMAND", [], []).partition("COMMAND`")[2].splitlines()[0] in page
