"""curionav coverage RUN...: coverage counted again from stored poses, by any marking rule and denominator.

Where the agent predicted what it would see, its predictions are drawn too.
"""

from __future__ import annotations

from curionav_cli.commands import predictions
from curionav_cli.commands.summary import a_console, print_files, print_table
from curionav_cli.commands.words import sorted_out
from curionav_cli.errors import ConfigError
from curionav_cli.results import plots
from curionav_cli.results.coverage import DENOMINATORS, RULES
from curionav_cli.results.runs import Run, tell_apart
from curionav_cli.storage.run_folder import RunFolder

CHOICES = {"marking": tuple(RULES), "denominator": DENOMINATORS}
SHOWN = ("agent", "seed", "marking", "of", "coverage", "visited", "cells", "area", "to 50 %", "to 80 %", "to 90 %",
         "steps", "state", "env")


def run(words: list[str]) -> int:
    """Print a row for every run, rule and denominator, and draw them; the exit code.

    words: folders of runs or sweeps, and marking=... or denominator=... to have only those.
    """
    paths, chosen = sorted_out("coverage", words, CHOICES)
    folders = [run for path in paths for run in RunFolder.found(path)]
    if not folders:
        raise ConfigError("Name the folder of a run or a sweep, as in: curionav coverage outputs/DATE/RUN")
    rules, denominators = ((chosen[key],) if key in chosen else CHOICES[key] for key in CHOICES)
    counted = [Run(folder, rule, denominator) for folder in folders for rule in rules for denominator in denominators]
    console = a_console()
    print_table([one.row() for one in counted], console, SHOWN)
    runs = [Run(folder) for folder in folders]
    tell_apart(runs)
    for line in filter(None, map(predictions.line, runs)):
        console.print(line, soft_wrap=True, highlight=False)
    for table in filter(None, map(predictions.surprise_table, runs)):
        console.print(table)
    for one in runs:
        made = [name for way in counted if way.folder is one.folder for name in draw(way)]
        print_files(console, one.folder.path, made + predictions.draw(one))
    for path in predictions.draw_seeds(runs):
        print_files(console, path.parent, [path.name])
    return 0


def draw(one: Run) -> list[str]:
    """Heatmap and curve by this rule and denominator; their names in the run folder."""
    share = f"{one.coverage.share:.1%} of {one.coverage.total} {one.denominator} cells"
    figures = {"heatmap": plots.heatmap(one.coverage, f"{one.label}\n{share}"),
               "coverage": plots.curves([one], one.label)}
    names = {kind: f"figures/{kind}_{one.rule}_{one.denominator}.png" for kind in figures}
    for kind, figure in figures.items():
        plots.save(figure, one.folder.path / names[kind])
    return list(names.values())
