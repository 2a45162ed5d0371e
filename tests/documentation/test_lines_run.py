"""Every command line of the docs is run, shortened by one rule, beside runs of its own.

The rule: one episode of 100 steps, one iteration or update, two requests to dock, two trials, the first two jobs of a
sweep. A line that makes a folder makes it anew. NOT_RUN says which lines are not run, and why.
"""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from entry import Cli
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from office import write_two_rooms
from test_docs import GENERATED, PAGES, ROOT, commands, put_configs, words_to_type

from curionav_cli.config import compose

pytestmark = [pytest.mark.slow, pytest.mark.timeout(3600), pytest.mark.usefixtures("blank_figures")]
NOT_RUN = {
    "env=live": "needs a robot: tests/live",
    "robot check": "needs a robot: tests/live",
    "robot.host=": "needs a robot: tests/live",
    "serve ": "needs a rosbridge server: tests/live",
    "launcher=slurm": "needs Slurm: tests/slurm",
    "s3://": "needs a bucket: tests/remote",
    "--follow": "waits for a robot: tests/remote",
    "learner=remote": "waits for a server: tests/remote",
    "watch ": "goes on until Ctrl-C: tests/execution/watching",
    "logger=trackio": "needs an environment of its own: make trackers",
    "agent=turner": "needs files: test_another_agent.py",
    "env=replica_apartment_": "needs scans: test_scan_commands.py",
    "paper changes": "needs runs of a world in which things move: tests/results/test_changes.py",
    "--install-completion": "writes into the settings of the shell",
    "wandb": "starts a program of its own: tests/storage/test_trackers.py",
}
NAMED = {"export --to mcap", "paper figures"}  # in a sentence, without what they are given
SHORT = {"loop.episodes": "1", "loop.steps": "100", "loop.iterations": "1"}
SHORTENED = {  # the words of a command that are set, whether they stand there or not
    "explore": SHORT, "train": {"loop.iterations": "1"}, "evaluate": {"loop.episodes": "1"},
    "dock": {"dock.requests": "2", "loop.steps": "40"},
}
LONGER = {"loop.episodes": "2", "dock.requests": "3", "loop.iterations": "2"}  # of resume, where they stand there
RUN = {"docking.md": "dock env=small_room robot=turtlebot2i"}  # what RUN is of; elsewhere:
EXPLORED = "explore env=small_room agent=lbs_dreamer"
RECORDS = ("history", "benchmarks", "comparison")  # what was run once, with the versions of then


@pytest.fixture(scope="module")
def prepared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for what all pages share, by command."""
    return tmp_path_factory.mktemp("prepared")


@pytest.fixture
def page(request: pytest.FixtureRequest) -> Path:
    return request.param


@pytest.fixture
def beside(cli: Cli, page: Path, prepared: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cli]:
    """The entry point beside what pages name: a map, a config directory, a run, a sweep, an evaluation, a card."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(compose, "COMPOSED", 1)
    divide = BasicSweeper.split_arguments
    monkeypatch.setattr(BasicSweeper, "split_arguments", staticmethod(
        lambda *arguments: [batch[:2] for batch in divide(*arguments)]))
    write_two_rooms(tmp_path)
    put_configs(tmp_path)
    run = RUN.get(page.name, EXPLORED)
    made(cli, prepared, f"{run} hydra.run.dir=outputs/DATE/RUN")
    told = "\n".join(" ".join(words_to_type(words, tmp_path)) for words in commands(page))
    if "SWEEP" in told:
        made(cli, prepared, "explore -m env=small_room agent=lbs_dreamer,random,bounce seed=range(2) "
                            "hydra.sweep.dir=outputs/DATE/SWEEP")
    if "map outputs/DATE/RUN" in told:
        made(cli, prepared, "explore env=small_room agent=mapper hydra.run.dir=outputs/DATE/MAPPED")
    if "EVALUATION" in told:
        made(cli, prepared, "evaluate outputs/DATE/RUN hydra.run.dir=outputs/DATE/EVALUATION")
    if "pretrained=apartments" in told:
        made(cli, prepared, "card outputs/DATE/RUN pretrained=apartments")
    if "page=" in told:
        shutil.copytree(ROOT / "docs", "docs", ignore=lambda _, names: [name for name in names if ".md" not in name])
    if "mcap" in told:
        made(cli, prepared, "export outputs/DATE/RUN --to mcap out=recorded")
        shutil.copy(next((tmp_path / "recorded").rglob("*.mcap")), tmp_path / "office.mcap")
    if ".glb" in told:
        made(cli, prepared, "export env=small_room to=glb out=flat.glb")
    yield cli


def made(cli: Cli, prepared: Path, line: str) -> None:
    """Run a line, once for all pages of a process: what it has written is copied."""
    kept = prepared / line.replace("/", "_")
    if kept.exists():
        shutil.copytree(kept, Path.cwd(), dirs_exist_ok=True)
        return
    before = {path for path in Path.cwd().rglob("*") if path.is_file()}
    answer = cli(*short(shlex.split(line), Path.cwd()))
    assert answer.code == 0, (line, answer.error)
    for path in Path.cwd().rglob("*"):
        if path.is_file() and path not in before:
            target = kept / path.relative_to(Path.cwd())
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, target)


def short(words: list[str], folder: Path) -> list[str]:
    """The words by the rule."""
    words = words_to_type(words, folder)
    if "--help" in words:
        return words
    command, *rest = words
    if command == "map":  # of a run that made one
        rest = [word.replace("outputs/DATE/RUN", "outputs/DATE/MAPPED") for word in rest]
    keys = {word.partition("=")[0] for word in rest}
    change = dict(SHORTENED.get(command, {}))
    if command == "resume":
        change = {key: value for key, value in LONGER.items() if key in keys}
    if any(word.startswith("agent=sb3") for word in rest):
        del change["loop.steps"]  # rollouts of agent.unroll steps
    if "agent.options=seven" in rest:
        change["loop.steps"] = "340"  # a learner's sequences of options of up to 17 steps fit into it
    if "hydra/sweeper=optuna" in rest or "experiment=search" in rest:
        change["hydra.sweeper.n_trials"] = "2"
    return [command, *(word for word in rest if word.partition("=")[0] not in change),
            *(f"{key}={value}" for key, value in change.items())]


def makes(words: list[str]) -> list[str]:
    """The folders that a line makes; curionav paper writes into those that are there, beside pages."""
    if words[0] == "paper":
        return []
    named = [word.partition("=")[2] for word in words
             if word.startswith(("hydra.run.dir=", "hydra.sweep.dir=", "out=", "pretrained="))]
    beside = {"card": "card", "export": "bags", "init": "."}.get(words[0], "")
    return named or [f"{word.removesuffix('...')}/{beside}" for word in words[1:2] if beside]


def thins(words: list[str]) -> bool:
    """Whether a line removes images, which others read: it is run after them."""
    return words[0] == "resume" and any(word.startswith("loop.keep=") for word in words)


def not_run(line: str) -> str:
    """Why a line is not run; empty where it is."""
    if line in NAMED:
        return "names a command"
    return next((reason for part, reason in NOT_RUN.items() if part in line), "")


READ = [page for page in PAGES if page != GENERATED and not set(page.parts) & set(RECORDS) and list(commands(page))]


@pytest.mark.parametrize("page", READ, ids=lambda page: str(page.relative_to(ROOT)), indirect=True)
def test_every_line_of_a_page_runs(beside: Cli, page: Path, tmp_path: Path) -> None:
    if page.name == "sb3.md":
        pytest.importorskip("sb3_contrib", reason="the extra sb3 is not installed")
    failed = {}
    for words in sorted(commands(page), key=thins):
        line = shlex.join(words)
        if not_run(line):
            continue
        for folder in makes(words):
            shutil.rmtree(tmp_path / folder, ignore_errors=True)
        answer = beside(*short(words, tmp_path))
        if answer.code:
            failed[line] = f"{answer.code} {answer.error}"
    assert not failed, "\n".join(f"{line}: {said}" for line, said in failed.items())


def test_every_reason_is_that_of_a_line() -> None:
    lines = [shlex.join(words) for page in READ for words in commands(page)]
    assert [part for part in NOT_RUN if not any(part in line for line in lines)] == []
