"""The last lines of a command: a table of all runs, where the files are, what to type next."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.box import SIMPLE
from rich.cells import cell_len
from rich.console import Console
from rich.table import Table
from rich.text import Text

from curionav_cli.config.search import NOTE, noted
from curionav_cli.config.settings import read_settings
from curionav_cli.errors import UserError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import file_name, write_bytes
from curionav_cli.results import plots, tables
from curionav_cli.results.runs import Run, distinguish, job_number
from curionav_cli.storage.pictures import gone

SHOWN = ("agent", "seed", "coverage", "visited", "cells", "steps", "area", "to 50 %", "to 80 %", "forward", "left",
         "right", "cancelled", "state", "env", "learning")  # the most important first: a narrow terminal shows fewer
SWEPT = ("folder", "state", "coverage", *(heading for heading in SHOWN if heading not in ("state", "coverage")))
LEFT = ("run", "folder", "agent", "state", "env", "marking", "of", "arm", "minus", "setting", "value",
        "part", "name", "key", "where in the paper", "what", "paper", "ours", "from")


def show(folder: Path, folders: Sequence[Path]) -> None:
    """Print the summary of the run in `folder`, or of the sweep that has its runs in `folders`."""
    console = a_console()
    if (folder / "config.yaml").exists():
        show_run(folder, console)
    elif names := {path.name for path in [*folders, *(file.parent for file in folder.glob("*/run.json"))]
                   if path.resolve() != folder.resolve()}:
        show_sweep(folder, [folder / name for name in sorted(names, key=job_number)], console)


def show_run(folder: Path, console: Console) -> None:
    """Print the summary of one run."""
    run = Run.open(folder)
    row = run.row()
    print_table([row], console)
    print_files(console, folder, ("figures/heatmap.png", "figures/coverage.png", "figures/predictions.png",
                                  "figures/prediction_error.png", "figures/probe.png", "table.md", "episodes"))
    on = f"curionav resume {shlex.quote(str(folder))}"
    longer = [f"{on} loop.episodes={2 * row['episodes']}   (the same run, longer)"] if can_be_longer(run) else []
    print_next(console, [*(longer if row["state"] == "done" else [on]),
                         "curionav explore -m agent=lbs_dreamer,random,bounce seed=0,1,2,3,4",
                         "curionav explore --help   (every setting)"])


def show_sweep(root: Path, folders: Sequence[Path], console: Console) -> None:
    """Draw figures over the runs of a sweep, write their tables, and print its summary."""
    runs, rows = [], []
    for folder in folders:
        try:
            run = Run.open(folder)
            rows.append(run.row())
            if run.coverage.steps:
                runs.append(run)
        except UserError as error:
            rows.append(failed_row(folder, error))
    distinguish(runs)
    search = noted(root)
    if towards := search.get("direction"):  # of a search: the best first
        rows.sort(key=lambda row: best_first(row, towards))
    names = {str(run.folder.path): {"env": run.env, "agent": run.agent} for run in runs}
    rows = [{**row, **names.get(row["folder"], {})} for row in rows]
    made = draw(root, runs)
    columns = (*tables.columns_of(rows), ("folder", "name", "{}"))
    named = [{**row, "name": Path(row["folder"]).name} for row in rows]
    write_text(root / "table.md", tables.markdown(named, columns))
    write_text(root / "results.csv", tables.comma_separated(rows))
    print_columns(named, columns, console, SWEPT, tables.meaning(rows))
    for row in rows:
        if row["state"] != "done":
            console.print(f"{row['state']}: {row['folder']}: {row['error']}", soft_wrap=True, markup=False)
    print_files(console, root, [*made, "table.md", "results.csv", "optimization_results.yaml"])
    print_next(console, [*how_to_continue(root, rows, search, all(map(can_be_longer, runs))),
                         f"curionav compare {shlex.quote(str(root))}   (intervals, and report.html)",
                         "curionav explore -m agent=lbs_dreamer,random,bounce seed=0,1,2,3,4 launcher=cores",
                         "curionav explore --help   (every setting)"])


def best_first(row: dict[str, Any], direction: str) -> float:
    """The sort key of a run in the table of a search; runs without coverage come last."""
    coverage = row.get("coverage")
    return float("inf") if coverage is None else -coverage if direction == "maximize" else coverage


def can_be_longer(run: Run) -> bool:
    """Whether a run that is done can get more episodes: what learns from those that it has needs their images."""
    learns = any(row.get("updates") for row in run.folder.metrics())
    if not learns or not any(map(gone, run.episodes[-1:])):
        return True
    return read_settings(run.folder.config).loop.replay_episodes in (0, 1)


def how_to_continue(root: Path, rows: Sequence[dict[str, Any]], search: dict[str, Any], longer: bool) -> list[str]:
    """The command that resumes a sweep or makes it longer, where it can be; [] for one without a record of its command.
    """
    on, states = f"curionav resume {shlex.quote(str(root))}", {row["state"] for row in rows}
    if not (root / NOTE).is_file():
        return []
    if trials := search.get("n_trials"):
        done = len(rows) >= trials and "interrupted" not in states
        return [f"{on} hydra.sweeper.n_trials={2 * trials}   (the same search, longer)" if done else on]
    if states == {"done"}:
        most = 2 * max(row["episodes"] for row in rows)
        return [f"{on} loop.episodes={most}   (the same runs, longer)"] if longer else []
    return [f"{on} --failed   (what failed, once more)" if "failed" in states else on]


def failed_row(folder: Path, error: UserError) -> dict[str, Any]:
    """The row of a run that cannot be read."""
    keys = ("env", "agent", "seed", "state", "episodes", "steps", "marking", "denominator", "visited", "cells")
    return {**dict.fromkeys(keys), "marking": "landing", "denominator": "visitable", "state": "failed",
            "error": str(error), "folder": str(folder)}


def draw(root: Path, runs: Sequence[Run]) -> list[str]:
    """Draw a coverage figure and a row of heatmaps for each environment; returns their names in the folder."""
    made = []
    for env in dict.fromkeys(run.env for run in runs):
        same = [run for run in runs if run.env == env]
        (root / "figures").mkdir(exist_ok=True)
        for kind, figure in (("coverage", plots.curves(same, env)), ("heatmaps", plots.heatmaps(one_each(same)))):
            made.append(f"figures/{kind}_{file_name(env)}.png")
            plots.save(figure, root / made[-1])
    return made


def one_each(runs: Sequence[Run]) -> list[Run]:
    """The first run of every agent; of a single agent its first eight runs."""
    first = list({run.agent: run for run in reversed(runs)}.values())[::-1]
    return first if len(first) > 1 else list(runs[:8])


def write_text(path: Path, text: str) -> None:
    """Write a file that is whole or absent."""
    write_bytes(path, text.encode())


def print_table(rows: Sequence[dict[str, Any]], console: Console, shown: Sequence[str] = SHOWN) -> None:
    """Print a table of runs, with as many columns as fit the terminal."""
    columns = tables.columns_of(rows)
    shown = [*shown, *(heading for heading, _, _ in columns[len(tables.COLUMNS):])]
    print_columns(rows, columns, console, shown, None if "marking" in shown else tables.meaning(rows))


def print_columns(rows: Sequence[dict[str, Any]], columns: tables.Columns, console: Console, shown: Sequence[str],
                  caption: str | None = None) -> None:
    """Print the columns with the headings in `shown`, as many as fit the terminal; a file gets them all."""
    headings = [heading for heading, _, _ in columns]
    lines = [dict(zip(headings, tables.cells(row, columns), strict=True)) for row in rows]
    table = Table(box=SIMPLE, pad_edge=False, caption=caption, caption_justify="left")
    used = 0
    for heading in shown:
        used += 3 + max(len(heading), *(cell_len(line[heading]) for line in lines))
        if used > console.width and console.is_terminal:
            break
        table.add_column(heading, justify="left" if heading in LEFT else "right", no_wrap=True)
    hidden = len(shown) - len(table.columns)
    if hidden:
        more = "1 more column needs" if hidden == 1 else f"{hidden} more columns need"
        table.caption = "\n".join([*filter(None, [caption]), f"{more} a wider terminal."])
    for line in lines:
        table.add_row(*(Text(line[heading]) for heading in shown[:len(table.columns)]))  # brackets are no markup
    (console if console.is_terminal else Console(file=console.file, width=max(used, console.width))).print(table)


def print_files(console: Console, root: Path, names: Sequence[str]) -> None:
    """Print the paths of those files in `root` that exist."""
    console.print("\n[bold]Files[/]")
    for path in (root / name for name in names):
        if path.exists():
            console.print(f"  {path}", soft_wrap=True, highlight=False, markup=False)


def print_next(console: Console, lines: Sequence[str]) -> None:
    """Print the commands to type next."""
    console.print("\n[bold]Next[/]")
    for line in lines:
        console.print(f"  {line}", soft_wrap=True, highlight=False, markup=False)
