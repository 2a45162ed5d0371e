"""report.html: everything that a comparison found, on one page that can be sent to somebody."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from curionav_cli.commands.summary import write_text
from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_json
from curionav_cli.records import Episode
from curionav_cli.results import film, plots
from curionav_cli.results.comparison import html_report
from curionav_cli.results.comparison.comparison import Comparison, Field
from curionav_cli.results.comparison.html_report import Picture, Section
from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.comparison.tables import Table, run_table, version_table
from curionav_cli.results.runs import Run
from curionav_cli.results.tables import Row
from curionav_cli.storage import provenance
from curionav_cli.storage.run_folder import RunFolder

EVERY = 5  # steps of a film that many people load
MADE_WITH = ("curionav", "git_commit", "git_changed", "python", "numpy", "torch", "gymnasium", "opencv-python-headless",
             "device", "engine", "machine", "cores", "threads")


def best_runs(field: Field, way: tuple[str, str]) -> list[Run]:
    """Of each arm the run that covered most, counted by this marking rule and denominator."""
    found = []
    for arm, lives in field.arms.items():
        best = max(lives, key=lambda life: (life.curve.at(field.horizon), life.curve.until(field.horizon).area()))
        found.append(Run(RunFolder(best.folder), *way, arm.removeprefix(best.agent)))
    return found


def holes(runs: Sequence[Run]) -> list[str]:
    """A line for each of these runs that noted more than its episodes hold: one of them is broken."""
    return [f"GAP: {gap}" for run in runs for gap in run.readable.gaps]


def draw_best(best: dict[str, list[Run]], figures: Path) -> list[str]:
    """The heatmaps of the best runs side by side, a figure for each environment; their names in the folder."""
    for name, runs in best.items():
        plots.save(plots.heatmaps(runs), figures / f"heatmaps_{name}.png")
    return [f"heatmaps_{name}.png" for name in best]


def shoot(runs: Sequence[Run], path: Path) -> str:
    """A film of the last episode of the run that covered most; what it shows. Empty: there can be none."""
    best = max(runs, key=lambda run: run.coverage.visited)
    try:
        episode = Episode.load(best.episodes[-1])
        film.write(film.frames(best.plan, episode, f"episode {len(best.episodes) - 1}", EVERY), path)
    except RunFolderError:
        return ""
    return f"{best.label}: its last episode, from within and from above."


def write(path: Path, command: str, comparison: Comparison, notes: Sequence[str], tables: Sequence[Table],
          pictures: Sequence[Picture], rows: Sequence[Row]) -> None:
    """The page. rows: one for each run."""
    about = [made(life) for life in comparison.names]
    curves = [one for one in pictures if not one.path.name.startswith("heatmaps") and one.path.suffix == ".png"]
    maps = [one for one in pictures if one not in curves]
    settings = [html_report.table(one) for one in tables if one.name == "settings"]
    numbers = [html_report.table(one) for one in tables if one.name != "settings"]
    page = html_report.page(
        f"{', '.join(comparison.arms)} in {', '.join(field.env for field in comparison.fields)}",
        " ".join(dict.fromkeys(str(one["question"]) for one in about if one.get("question"))),
        [Section("What to know", html_report.notes(notes)),
         Section("Curves", [html_report.picture(one) for one in curves]),
         Section("Heatmaps", [html_report.picture(one) for one in maps]),
         Section("Tables", numbers), Section("What differs", settings),
         Section("Runs", [html_report.table(run_table(rows))]),
         Section("Made by", html_report.commands([*sweeps(list(comparison.names)), command])
                 + [html_report.table(version_table(versions(about)))])])
    write_text(path, page)


def made(life: RunSummary) -> dict[str, Any]:
    """run.json; {} where it cannot be read."""
    try:
        return read_json(life.folder / "run.json")
    except RunFolderError:
        return {}


def sweeps(lives: Sequence[RunSummary]) -> list[str]:
    """The command of each sweep once; of a run that is in none, its own."""
    commands = (provenance.sweep_command(life.folder.resolve().parent) or str(made(life).get("command", ""))
                for life in lives)
    return [command for command in dict.fromkeys(commands) if command]


def versions(about: Sequence[dict[str, Any]]) -> list[Row]:
    """What the runs were made with, and how many by each."""
    return [{"what": key, "value": str(value), "n": n} for key in MADE_WITH
            for value, n in Counter(one.get(key) for one in about).items() if value is not None]
