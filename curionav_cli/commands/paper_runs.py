"""curionav paper figures RUN... and curionav paper changes RUN...: from runs of any length, also unfinished ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from curionav_cli.commands.coverage import opened
from curionav_cli.commands.summary import print_columns, print_files, write_text
from curionav_cli.errors import ConfigError
from curionav_cli.files import file_name
from curionav_cli.results import change_plots, changes, paper_figures, plots, tables
from curionav_cli.results.comparison.comparison import compare
from curionav_cli.results.comparison.parallel import read_all
from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.runs import distinguish

NAME_RUNS = "There is no run to read. Name folders of runs or sweeps, as in: curionav paper {} outputs/DATE/SWEEP"


def run(what: str, folders: Sequence[Path], out: Path, console: Console) -> int:
    """Draw and write what one of `figures` and `changes` is; returns the exit code."""
    made, parts, lost = (figures if what == "figures" else effects)(folders, out)
    for part in parts:
        print_columns(part.rows, part.columns, console, [heading for heading, _, _ in part.columns], part.title)
        write_text(out / f"{part.name}.csv", tables.comma_separated(part.rows))
    write_text(out / f"{what}.md", "\n".join(tables.markdown(part.rows, part.columns, part.title) for part in parts))
    for line in lost:
        console.print(line, soft_wrap=True, highlight=False, markup=False)
    print_files(console, out, [*made, f"{what}.md", *(f"{part.name}.csv" for part in parts)])
    return 0


def figures(folders: Sequence[Path], out: Path) -> tuple[list[str], list[Table], list[str]]:
    """The paper's figures of coverage, a table of the runs, and a line about each run that cannot be shown."""
    runs, lost = read_all(folders, "landing", "visitable")
    if not runs:
        raise ConfigError("\n".join([*lost, NAME_RUNS.format("figures")]))
    comparison = compare(runs)
    shown, made = paper_figures.drawn(comparison), []
    for name, figure in paper_figures.figures(shown, plots.looks(comparison.arms)):
        plots.save(figure, out / f"{name}.png")
        made.append(f"{name}.png")
    rows = paper_figures.rows(shown)
    unfinished = [f"Not finished ({row['state']}): {row['env']}, {row['arm']}, seed {row['seed']}, {row['steps']:,} "
                  "steps; its curve ends there." for row in rows if row["state"] != "done"]
    return made, [Table("runs", "One row a run; the paper's: steps at which its curve ends.", paper_figures.COLUMNS,
                        rows)], [*unfinished, *lost]


def effects(folders: Sequence[Path], out: Path) -> tuple[list[str], list[Table], list[str]]:
    """What moved objects do to surprise and coverage, a figure for each environment, and a line about runs left out."""
    runs, lost = opened(folders)
    if not runs:
        raise ConfigError("\n".join([*lost, NAME_RUNS.format("changes")]))
    distinguish(runs)
    found, alone = changes.pairs(runs)
    if not found:
        raise ConfigError("\n".join([*lost, *alone, "Nothing moved in any of these runs. Give one with "
                                                    "env.changes=true, of a world in which things move."]))
    made = []
    for scene in dict.fromkeys(one.run.config["env"]["name"] for one in found):
        here = [one for one in found if one.run.config["env"]["name"] == scene]
        made.append(f"changes_{file_name(scene)}.png")
        plots.save(change_plots.figure(here, scene), out / made[-1])
    parts = [Table("changes", changes.BELOW, changes.COLUMNS, [changes.summary(one) for one in found]),
             Table("surprise_by_age", "Surprise near what moved, by the age of the move.", changes.AGE_COLUMNS,
                   [row for one in found for row in changes.age_rows(one)])]
    return made, [part for part in parts if part.rows], [*alone, *lost]
