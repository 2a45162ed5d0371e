"""report.html: a whole comparison on one page without other files."""

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
from curionav_cli.results.comparison.comparison import Field
from curionav_cli.results.comparison.html_report import Picture, Section
from curionav_cli.results.comparison.tables import Table, run_table, version_table
from curionav_cli.results.runs import Run
from curionav_cli.results.summary_file import SummaryFile, is_summary, opened
from curionav_cli.results.tables import Row
from curionav_cli.storage import provenance

EVERY = 5  # steps between two frames of the film, to keep the page small
MADE_WITH = ("curionav", "git_commit", "git_changed", "python", "numpy", "torch", "gymnasium", "opencv-python-headless",
             "device", "engine", "machine", "cores", "threads")


def best_runs(field: Field, counting: tuple[str, str]) -> list[Run]:
    """The run of each arm that covered most, by this marking rule and denominator."""
    best_of_arms = []
    for arm, runs in field.arms.items():
        best = max(runs, key=lambda run: (run.curve.at(field.horizon), run.curve.until(field.horizon).area()))
        best_of_arms.append(opened(best.folder, *counting, arm.removeprefix(best.agent)))
    return best_of_arms


def gap_lines(runs: Sequence[Run]) -> list[str]:
    """A line for each gap in these runs: metrics of an episode that is missing or broken."""
    return [f"GAP: {gap}" for run in runs for gap in run.readable.gaps]


def draw_best(best: dict[str, list[Run]], figures: Path) -> list[str]:
    """Draw the heatmaps of the best runs side by side, a figure for each environment; returns their names."""
    for name, runs in best.items():
        plots.save(plots.heatmaps(runs), figures / f"heatmaps_{name}.png")
    return [f"heatmaps_{name}.png" for name in best]


def film_last_episode(runs: Sequence[Run], path: Path) -> str:
    """Make a film of the last episode of the run that covered most; returns its caption, "" where it cannot be made."""
    runs = [run for run in runs if not is_summary(run.folder.path)]  # which have no episodes
    if not runs:
        return ""
    best = max(runs, key=lambda run: run.coverage.visited)
    try:
        episode = Episode.load(best.episodes[-1])
        film.write(film.frames(best.plan, episode, f"episode {len(best.episodes) - 1}", EVERY), path)
    except RunFolderError:
        return ""
    return f"{best.label}: its last episode, from within and from above."


def write(path: Path, command: str, title: str, folders: Sequence[Path], notes: Sequence[str], tables: Sequence[Table],
          pictures: Sequence[Picture], rows: Sequence[Row]) -> None:
    """Write the page. folders: of all runs; rows: one for each that has a coverage."""
    about = [run_json(folder) for folder in folders]
    curves = [picture for picture in pictures
              if picture.path.suffix == ".png" and not picture.path.name.startswith("heatmaps")]
    maps = [picture for picture in pictures if picture not in curves]
    settings = [html_report.table(table) for table in tables if table.name == "settings"]
    numbers = [html_report.table(table) for table in tables if table.name != "settings"]
    page = html_report.page(
        title,
        " ".join(dict.fromkeys(str(record["question"]) for record in about if record.get("question"))),
        [Section("What to know", html_report.notes(notes)),
         Section("Curves", [html_report.picture(picture) for picture in curves]),
         Section("Heatmaps", [html_report.picture(picture) for picture in maps]),
         Section("Tables", numbers), Section("What differs", settings),
         Section("Runs", [html_report.table(run_table(rows))]),
         Section("Made by", html_report.commands([*sweeps(folders), command])
                 + [html_report.table(version_table(versions(about)))])])
    write_text(path, page)


def run_json(folder: Path) -> dict[str, Any]:
    """The content of run.json, or what a summary file holds of it; {} where it cannot be read."""
    try:
        return SummaryFile.load(folder).about if is_summary(folder) else read_json(folder / "run.json")
    except RunFolderError:
        return {}


def sweeps(folders: Sequence[Path]) -> list[str]:
    """The command of each sweep once, and of each run that is in none."""
    commands = (provenance.sweep_command(folder.resolve().parent) or str(run_json(folder).get("command", ""))
                for folder in folders)
    return [command for command in dict.fromkeys(commands) if command]


def versions(about: Sequence[dict[str, Any]]) -> list[Row]:
    """The versions and machines that the runs were made with, and the number of runs of each."""
    return [{"what": key, "value": str(value), "n": n} for key in MADE_WITH
            for value, n in Counter(record.get(key) for record in about).items() if value is not None]
