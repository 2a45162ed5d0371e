"""curionav paper WHAT: the paper's tables from configs and scenes, and each of its numbers beside ours."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from curionav_cli import build
from curionav_cli.commands import diagram, paper_runs
from curionav_cli.commands.arguments import one_of, sorted_out
from curionav_cli.commands.summary import print_columns, print_files, write_text
from curionav_cli.config.compose import composed
from curionav_cli.errors import ConfigError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import folder_for
from curionav_cli.places import place
from curionav_cli.records import FloorPlan
from curionav_cli.results import page_blocks, paper, paper_lengths, paper_page, tables
from curionav_cli.results.comparison import estimates
from curionav_cli.results.comparison.comparison import Comparison
from curionav_cli.results.comparison.comparison import compare as compared
from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.docking import came_home
from curionav_cli.results.summary_file import is_summary
from curionav_cli.results.tables import Row
from curionav_cli.storage.run_folder import RunFolder

WHAT = ("hyperparameters", "sizes", "docking", "numbers", "figures", "changes")
OF_RUNS = ("numbers", "figures", "changes")
CHOICES: dict[str, tuple[str, ...]] = {"out": (), "page": (), "keep": ("yes", "no")}
PAGE = "paper-vs-ours.md"
TITLES = {
    "protocol": "Episodes, steps, cells and battery.", "surfaces": "Sizes of the worlds.",
    "coverage": "Coverage after the steps that were run; the paper's is after more steps where the row says so.",
    "docking": f"Returns to dock of robot={paper.ROBOT} that ended docked without a person's help.",
}
BEYOND = (  # what no run here can show, and why
    ("Coverage in Replica's apartments", "its scans are not part of this project. Ours are drawn homes with as many "
     "visitable cells; their walls and textures differ."),
    ("Coverage, docking and moved objects in the two real rooms", "there is no robot here. `robot=turtlebot2i` "
     "simulates drift, bumps, sensors and battery. Its constants were fitted to the paper's docking rates, so those "
     "rates are no test of it."),
    ("Photographs of the rooms", "ours are contact sheets of scenes with the same size and kind of clutter."),
    ("Training on a GTX 1080", "the cost of updates was measured on other machines (benchmarks/RESULTS.md)."),
    ("Curves and heatmaps of the paper's figures", "the paper prints them without numbers, so only what its "
     "text says of them can be compared."),
)


def run(words: list[str]) -> int:
    """Print and write one of WHAT; returns the exit code. words: which one, folders of runs, out=DIR, page=PAGE."""
    what = one_of("paper", words[0] if words else "", WHAT)
    folders, chosen = sorted_out("paper", words[1:], CHOICES)
    if folders and what not in OF_RUNS:
        raise ConfigError(f"curionav paper {what} reads no runs, only settings. Leave out {folders[0]}.")
    if "page" in chosen and what not in paper_page.NAMES:
        raise ConfigError(f"curionav paper {what} has no page=. That goes with {' and '.join(paper_page.NAMES)}.")
    if "keep" in chosen and what != "figures":
        raise ConfigError(f"curionav paper {what} has no keep=. That goes with figures.")
    out, command = folder_for(chosen.get("out", ".")), shlex.join(["curionav", "paper", *words])
    console = a_console()
    lost: list[str] = []
    if what == "docking":
        out.mkdir(parents=True, exist_ok=True)
        rooms = [composed("paper", f"env={env}", "agent=bounce", "robot=turtlebot2i") for env in diagram.ROOMS]
        print_files(console, out, [diagram.draw(rooms, out)])
        return 0
    if what in paper_page.NAMES:
        pages = [place(page) for page in chosen.get("page", "").split(",") if page]
        return paper_runs.run(what, folders, out, console, command, pages, chosen.get("keep") == "yes")
    if what == "numbers":
        parts, lost = numbers(folders)
        texts = {PAGE: page_blocks.filled(page(command, parts, lost), written_before(out / PAGE))}
    else:
        parts = [hyperparameters() if what == "hyperparameters" else sizes()]
        texts = {f"{what}.{kind}": text for kind, text in written(parts[0]).items()}
    out.mkdir(parents=True, exist_ok=True)
    for part in parts:
        print_columns(part.rows, part.columns, console, [heading for heading, _, _ in part.columns], part.title)
    for note in lost:
        console.print(note, soft_wrap=True, highlight=False, markup=False)
    for name, text in texts.items():
        write_text(out / name, text)
    print_files(console, out, list(texts))
    return 0


def written_before(path: Path) -> page_blocks.Blocks:
    """What curionav paper figures wrote into the page that is there."""
    return page_blocks.blocks(path.read_text(encoding="utf-8", errors="replace") if path.is_file() else "")


def written(part: Table) -> dict[str, str]:
    """A table as Markdown, LaTeX and CSV."""
    return {"md": tables.markdown(part.rows, part.columns, part.title),
            "tex": tables.latex(part.rows, part.columns, part.title), "csv": tables.comma_separated(part.rows)}


def hyperparameters() -> Table:
    """The paper's hyperparameters beside those composed for both scales."""
    ours, small = (vars(composed("paper", f"scale={scale}").agent) for scale in ("paper", "cpu"))
    return Table("hyperparameters", "The paper's hyperparameters beside those that are composed here.",
                 paper.HYPERPARAMETER_COLUMNS, paper.hyperparameters(ours, small))


def sizes() -> Table:
    """The paper's sizes of worlds beside those of the scenes."""
    return Table("sizes", "Visitable states and surfaces: the paper's, and those of the scenes as they load.",
                 paper.SIZE_COLUMNS, paper.sizes(plans()))


def plans() -> dict[str, FloorPlan]:
    """The floor plan of each world that the paper gives a size of."""
    return {env: build.scene(composed("paper", f"env={env}")).plan for env in paper.SIZES}


def numbers(folders: Sequence[Path]) -> tuple[list[Table], list[str]]:
    """A table for each part of the paper, and a line about each thing that is missing or unsure."""
    trials = [run for folder in folders for run in RunFolder.inside(folder) or [RunFolder(folder)] if came_home(run)]
    explored = [folder for folder in folders if not only_docking_trials(folder, trials)]
    runs, lost = paper_lengths.read_learning(explored)
    if folders and not runs and not trials:
        raise ConfigError("\n".join([*lost, "There is no run to take numbers from. Name folders of runs or "
                                     "sweeps, or none."]))
    settings, scenes = composed("paper", "robot=turtlebot2i"), plans()
    comparison = compared(runs) if runs else Comparison([], {}, {}, {})
    parts = {"protocol": paper.protocol(asdict(settings.loop), asdict(settings.robot), scenes,
                                        asdict(settings.agent)["action_repeat"]),
             "surfaces": paper.areas(scenes), "coverage": paper.coverage(comparison),
             "docking": paper.docking(runs, trials)}
    rows: dict[str, list[Row]] = {name: [number._asdict() for number in found] for name, found in parts.items()}
    shown = [Table(name, TITLES[name], paper.COLUMNS, found) for name, found in rows.items() if found]
    missing = "coverage" if trials else "coverage and docking"
    notes = [*estimates.notes(comparison, None), *lost] if runs else [
        *lost, f"No run was given, so that nothing is said about {missing}."]
    if any(is_summary(run.folder) for run in runs):
        notes.append("Summaries of runs hold no poses: steps to the furthest area and returns to dock are counted of "
                     "run folders alone.")
    return [hyperparameters(), *shown], notes


def only_docking_trials(folder: Path, trials: Sequence[RunFolder]) -> bool:
    """Whether all runs in the folder are runs of curionav dock."""
    paths = [run.path for run in trials]
    return folder in paths or any(path.parent == folder for path in paths)


def page(command: str, parts: Sequence[Table], notes: Sequence[str]) -> str:
    """The Markdown page."""
    lines: list[Any] = [
        "# The paper's numbers beside ours\n",
        f"Written by `{command}`; nothing on this page is typed by hand but the paper's side. Coverage counts cells "
        "marked by landing out of visitable cells; the mean over n seeds stands with its 95 % t interval, a share of "
        "returns to dock with Wilson's. Steps to a share: the median, and how many runs arrived.\n"]
    for part in parts:
        lines += [f"## {part.name.capitalize()}\n", tables.markdown(part.rows, part.columns, part.title)]
    lines += [paper_page.SECTION]
    lines += ["## What cannot be reproduced here\n", *(f"- **{what}**: {why}" for what, why in BEYOND), ""]
    lines += ["## What to know about these runs\n", *(f"- {note}" for note in notes), ""] if notes else []
    return "\n".join(lines)
