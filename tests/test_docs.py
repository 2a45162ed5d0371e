"""The documentation: links resolve, the index leads everywhere, and commands are such as the command line accepts."""

from __future__ import annotations

import re
import shlex
import shutil
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from entry import Cli
from office import write_two_rooms

from curionav_cli import build
from curionav_cli.bags import source
from curionav_cli.build import World
from curionav_cli.commands import (
    card,
    compare,
    coverage,
    doctor,
    export,
    init,
    listing,
    paper,
    resume,
    robot,
    runs,
    serve,
    watch,
)
from curionav_cli.commands import map as map_command
from curionav_cli.commands.arguments import one_of, sorted_out
from curionav_cli.config import compose
from curionav_cli.config.schema import Config
from curionav_cli.config.settings import settings_yaml
from curionav_cli.execution import launch
from curionav_cli.live import connect
from curionav_cli.records import Episode
from curionav_cli.storage import loggers
from curionav_cli.storage.run_folder import RunFolder
from curionav_cli.world.scan import export as scan_export
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

ROOT = Path(__file__).resolve().parents[1]
INDEX = ROOT / "docs" / "index.md"
DOCS = sorted((ROOT / "docs").rglob("*.md"))
PAGES = [*(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "benchmarks/RESULTS.md")), *DOCS]
GENERATED = ROOT / "docs" / "reference" / "commands.md"  # usage lines of its own
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
    inline = [code for part in FENCE.sub("", text).split("\n\n") for code in re.findall(r"`([^`]+)`", part)]
    for line in (" ".join(line.removeprefix(".venv/bin/").split()) for line in [*lines, *inline]):
        if line.startswith("curionav "):
            yield shlex.split(line, comments=True)[1:]


@pytest.fixture(scope="module")
def named(tmp_path_factory: pytest.TempPathFactory, an_episode, a_plan) -> Path:
    """A folder with what pages name: a map, a scan, a run, its card and its bag, a sweep, an evaluation, a cache."""
    folder = tmp_path_factory.mktemp("named")
    write_two_rooms(folder)
    scan_export.export(Scene.from_dict(*plain("small_room")), folder / "flat.glb")
    shutil.copy(folder / "flat.glb", folder / "lab.glb")
    run = RunFolder(folder / "outputs" / "DATE" / "RUN")
    run.create(settings_yaml(compose.composed("explore")), {"env": {"name": "small_room"}}, {}, a_plan())
    run.save_episode(0, replace(an_episode(steps=100), action=np.zeros(100, np.int64)))  # actions are held
    settings, weights = compose.composed("explore"), run.checkpoints / "000001"
    weights.mkdir(parents=True)
    build.agent(settings, build.world(settings)).save(weights)
    (weights / "done").touch()
    card.run([str(run.path)])
    card.run([str(run.path), f"out={folder}/cache/curionav/pretrained/apartments"])
    shutil.copytree(run.path, folder / "outputs" / "DATE" / "EVALUATION")
    write_bag(run.path / "bags" / "episode_000000", replace(an_episode(steps=100), action=np.zeros(100, np.int64)))
    shutil.copy(run.path / "bags" / "episode_000000" / "episode_000000.mcap", folder / "office.mcap")
    for name in ("0_small_room_lbs_dreamer_0", "1_small_room_lbs_dreamer_1"):
        shutil.copytree(run.path, folder / "outputs" / "DATE" / "SWEEP" / name)
    (folder / "outputs" / "summaries").mkdir()
    (folder / "docs" / "length" / "runs").mkdir(parents=True)
    return folder


@pytest.fixture
def typed(cli: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: Path) -> Cli:
    """The entry point up to the moment when something would run, beside what pages name."""
    shutil.copytree(named, tmp_path, dirs_exist_ok=True)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(launch, "run_plan", lambda *_: 0)
    monkeypatch.setattr(compose, "COMPOSED", 1)  # of a sweep each value once
    for name, module in {"coverage": coverage, "compare": compare, "runs": runs, "paper": paper, "export": export,
                         "map": map_command, "card": card}.items():
        monkeypatch.setattr(module, "run", lambda words, name=name, module=module: accepted(name, module, words))
    monkeypatch.setattr(resume, "run", resumable)
    monkeypatch.setattr(robot, "check", lambda profile, words, move: robot.settings_of(profile, words) and 0)
    monkeypatch.setattr(serve, "run", lambda words, serving, names: serve.settings_of(words) and 0)
    monkeypatch.setattr(listing, "run", lambda group, config_dir: one_of("list", group, launch_groups()) and 0)
    monkeypatch.setattr(watch, "run", lambda folder, port: int(not folder.is_dir()))
    monkeypatch.setattr(loggers, "find_spec", lambda name: name)  # trackio needs an environment of its own
    monkeypatch.setattr(doctor, "run", lambda: 0)
    monkeypatch.setattr(init, "run", lambda folder: 0)
    return cli


def write_bag(folder: Path, episode: Episode) -> None:
    """Write a bag, where rosbags is installed."""
    pytest.importorskip("rosbags")
    from curionav_cli.bags.export import Form, write

    write(folder, episode, 0, Form(source.named("turtlebot4"), True, 10.0, 0.3), None, None, {})


def accepted(name: str, module, words: Sequence[str]) -> int:
    """Whether words of a command that reads run folders are such as it takes, and the folders are there."""
    if "to=glb" in words:
        return int(compose.composed("explore", words[0]) is None)
    folders, _ = sorted_out(name, words, module.CHOICES)
    if name == "paper":
        one_of(name, str(folders.pop(0)), module.WHAT)
    assert all(folder.is_dir() for folder in folders), words
    return 0


def resumable(folder: Path, changes: Sequence[str], failed: bool) -> int:
    """Whether some run may be resumed with these changes."""
    for change in changes:
        one_of("resume", change.partition("=")[0], list(chain(*resume.MAY_CHANGE.values())))
    assert folder.is_dir(), folder
    return 0


def launch_groups() -> tuple[str, ...]:
    return tuple(path.name for path in (ROOT / "conf").iterdir() if path.is_dir())


PLACEHOLDERS = {"RUN": "outputs/DATE/RUN", "SWEEP": "outputs/DATE/SWEEP", "DIR": "outputs/DATE/RUN", "GROUP": "env",
                "NAME": "small_room", "cuda": "cpu", "PROFILE": "turtlebot4", "COMMAND": "explore",
                "PAGE": "docs/paper-length.md",
                "benchmarks/conf": f"{ROOT}/benchmarks/conf"}
CABIN = re.compile(r"^Put this into `(\S+)`:\n\n```yaml\n(.*?)^```$", re.MULTILINE | re.DOTALL)
BY_ANOTHER_TEST = ("agent=turner", "env=replica_apartment_")  # test_another_agent.py, test_scan_commands.py
LONG = ("history", "comparison", "cbet.md")  # pages with sweeps of the apartments
WORLDS: dict[str, World] = {}
READS_RUNS = ("compare", "coverage", "paper", "map", "runs", "evaluate", "export")


@pytest.fixture
def beside(typed: Cli, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cli:
    """The same beside a config directory, mine, with the files that pages put there; robots answer."""
    put_configs(tmp_path)
    monkeypatch.setattr(connect, "refuse_unreachable", lambda settings: None)
    monkeypatch.setattr(build, "world", lambda settings, make=build.world: a_world(settings, make))
    return typed


def put_configs(folder: Path) -> None:
    """Write the config directory mine, with the files that pages put there."""
    shutil.copytree(init.STARTER, folder / "mine")
    for page in DOCS:
        for name, text in CABIN.findall(page.read_text(encoding="utf-8")):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text, encoding="utf-8")


def a_world(settings: Config, make: Callable[[Config], World]) -> World:
    """The world of some settings, built once for all pages."""
    key = repr((settings.env, settings.robot, settings.seed))
    if key not in WORLDS:
        WORLDS[key] = make(settings)
    return WORLDS[key]


def words_to_type(words: list[str], folder: Path) -> list[str]:
    """The words of a page with what it leaves open filled in; --help for a command that is only named."""
    if words == ["--install-completion"]:
        return ["--help"]
    if (len(words) == 1 and not words[0].startswith("-")) or words[-1].endswith("="):
        return [words[0], "--help"]
    if words == ["robot", "check"]:
        return [*words, "--help"]
    return [filled(word, words[0], folder) for word in words]


def filled(word: str, command: str, folder: Path) -> str:
    """A word with its placeholders replaced; a run that is not there is one that is."""
    key, equals, value = word.removesuffix("...").rpartition("=")
    value = PLACEHOLDERS.get(value, value).replace("URL", f"file://{folder}/store")
    if command in READS_RUNS and not equals and value.startswith("outputs/") and not (folder / value).exists():
        value = PLACEHOLDERS["SWEEP"]
    return f"{key}{equals}{value}"


PRE_FLIGHTED: set[str] = set()  # lines that an earlier page has too


@pytest.mark.parametrize("page", [
    pytest.param(page, id=str(page.relative_to(ROOT)), marks=[pytest.mark.slow] * bool(set(page.parts) & set(LONG)))
    for page in PAGES if page != GENERATED and list(commands(page))])
def test_every_command_of_a_page_passes_the_pre_flight(beside: Cli, tmp_path: Path, page: Path) -> None:
    if page.name == "sb3.md":
        pytest.importorskip("sb3_contrib", reason="the extra sb3 is not installed")
    refused = {}
    for words in commands(page):
        line = shlex.join(words)
        if line in PRE_FLIGHTED or any(part in line for part in BY_ANOTHER_TEST):
            continue
        answer = beside(*words_to_type(words, tmp_path))
        if answer.code:
            refused[line] = answer.error
        PRE_FLIGHTED.add(line)
    assert refused == {}


def test_the_page_of_the_papers_numbers_has_the_sentences_of_its_command() -> None:
    page = (ROOT / "docs" / "paper-vs-ours.md").read_text(encoding="utf-8")
    about = paper.page("COMMAND", [], []).splitlines()
    assert [line for line in about if "COMMAND" not in line and line not in page.splitlines()] == []
    assert [title for title in paper.TITLES.values() if title not in page] == []
    assert paper.page("COMMAND", [], []).partition("COMMAND`")[2].splitlines()[0] in page
