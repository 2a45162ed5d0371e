"""curionav compare RUN...: figures and tables over many runs, with confidence intervals, and one HTML page."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from pathlib import Path

import numpy as np

from curionav_cli.commands import report_page
from curionav_cli.commands.arguments import one_of, sorted_out
from curionav_cli.commands.summary import print_columns, print_files, write_text
from curionav_cli.errors import ConfigError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import file_name, folder_for
from curionav_cli.results import plots
from curionav_cli.results.comparison import estimates
from curionav_cli.results.comparison import plots as comparison_plots
from curionav_cli.results.comparison.comparison import Comparison, compare
from curionav_cli.results.comparison.html_report import Picture
from curionav_cli.results.comparison.parallel import read_all, workers
from curionav_cli.results.comparison.tables import (
    Table,
    arm_table,
    latex,
    markdown,
    overall_table,
    pair_table,
    settings_table,
)
from curionav_cli.results.coverage import DENOMINATORS, RULES
from curionav_cli.results.probing import estimates as probe_estimates
from curionav_cli.results.probing import plots as probe_plots
from curionav_cli.results.probing.curves import UPDATES, ProbeField, sort_into_fields
from curionav_cli.results.probing.curves import read_all as read_curves
from curionav_cli.results.runs import Run
from curionav_cli.results.summary_file import is_summary
from curionav_cli.results.tables import Row, comma_separated

CHOICES: dict[str, tuple[str, ...]] = {
    "marking": tuple(RULES), "denominator": DENOMINATORS, "baseline": (), "at": (), "out": ()}
THRESHOLDS = 101  # of a performance profile


def run(words: list[str]) -> int:
    """Compare, print and write; returns the exit code. words: folders of runs or sweeps, and settings of CHOICES."""
    paths, chosen = sorted_out("compare", words, CHOICES)
    folder = folder_for(chosen.get("out") or datetime.now().strftime("outputs/%Y-%m-%d/%H-%M-%S-%f_compare"))
    counting = chosen.get("marking", CHOICES["marking"][0]), chosen.get("denominator", DENOMINATORS[0])
    at = steps(chosen.get("at", ""))
    curves = read_curves(paths)
    runs, lost = read_all(paths, *counting, [curve.folder for curve in curves if curve.axis == UPDATES])
    if not runs and not curves:
        raise ConfigError("\n".join([*lost, "There is no run to compare. Name folders of runs or sweeps, as in: "
                                     "curionav compare outputs/DATE/SWEEP"]))
    comparison = compare(runs)
    probes, left_out = sort_into_fields(curves, {run.folder: names for run, names in comparison.names.items()})
    arms = list(dict.fromkeys([*comparison.arms, *(arm for field in probes for arm in field.arms)]))
    baseline = one_of("baseline", chosen["baseline"], arms) if "baseline" in chosen else None
    best = {file_name(field.env): report_page.best_runs(field, counting) for field in comparison.fields}
    notes = [*estimates.notes(comparison, baseline), *probe_estimates.notes(probes), *left_out, *lost]
    notes += [line for runs in best.values() for line in report_page.gap_lines(runs) if line not in notes]
    if any(is_summary(run.folder) for run in runs):
        notes.append("Summaries of runs hold neither episodes nor measurements on the probe: film and tables of the "
                     "probe are made of run folders alone.")
    report = Report(shlex.join(["curionav", "compare", *words]), comparison, probes, baseline, counting, at, notes)
    made = write(report, folder, best)
    console = a_console()
    for part in report.tables:
        print_columns(part.rows, part.columns, console, [heading for heading, _, _ in part.columns], part.title)
    for note in notes:
        console.print(note, soft_wrap=True, highlight=False, markup=False)
    print_files(console, folder, made)
    return 0


def steps(words: str) -> list[int]:
    """The numbers of '1000,5000'. Raises ConfigError for anything else."""
    if not re.fullmatch(r"(\d+(,\d+)*)?", words):
        raise ConfigError(f"at: {words!r} is not a list of steps. Write it as at=1000,5000")
    return [int(word) for word in words.split(",") if word]


@dataclass(frozen=True)
class Report:
    """A comparison and its tables, estimated once from a fixed seed."""

    command: str
    comparison: Comparison
    probes: list[ProbeField]
    baseline: str | None
    counting: tuple[str, str]
    at: list[int]
    notes: list[str]

    @property
    def counted(self) -> str:
        """How coverage was counted, in words."""
        return f"{self.counting[1]} cells, marked by {self.counting[0]}"

    @property
    def title(self) -> str:
        """The arms and their environments."""
        arms = [*self.comparison.arms, *(arm for field in self.probes for arm in field.arms)]
        envs = [*(field.env for field in self.comparison.fields), *(field.env for field in self.probes)]
        return f"{', '.join(dict.fromkeys(arms))} in {', '.join(dict.fromkeys(envs))}"

    @property
    def folders(self) -> list[Path]:
        """The folders of all runs."""
        probed = (curve.folder for field in self.probes for curves in field.arms.values() for curve in curves)
        return list(dict.fromkeys([*(run.folder for run in self.comparison.names), *probed]))

    @cached_property
    def tables(self) -> list[Table]:
        """The tables that have rows: arms, pairs, over all environments, probes, settings."""
        rng = np.random.default_rng(0)
        tables = [arm_table(list(estimates.arm_rows(self.comparison, self.at)), self.at, self.counted),
                 pair_table(list(estimates.pair_rows(self.comparison, self.baseline, rng))),
                 overall_table(list(estimates.overall_rows(self.comparison, rng))),
                 *probe_estimates.tables(self.probes, self.baseline, rng), settings_table(self.comparison)]
        return [table for table in tables if table.rows]

    def rows(self, name: str) -> list[Row]:
        """The rows of the table with this name."""
        return [row for table in self.tables if table.name == name for row in table.rows]


def draw_probes(fields: list[ProbeField], folder: Path) -> list[str]:
    """Draw a figure of the probes of each environment and axis; returns their names in the folder."""
    names = [f"figures/probe_{field.axis}_{file_name(field.env)}.png" for field in fields]
    for name, field in zip(names, fields):
        plots.save(probe_plots.figure(field, plots.looks(field.looks())), folder / name)
    return names


def draw(report: Report, folder: Path, best: dict[str, list[Run]]) -> list[str]:
    """Draw a figure for each environment and one over all of them; returns their names in the folder.

    None where there are only offline trainings, which cover nothing.
    """
    if not best:
        return []
    comparison, pairs = report.comparison, report.rows("pairs")
    base, look = report.baseline, plots.looks(comparison.arms)
    figures = {field.env: comparison_plots.environment(
        field, look, pairs, base or next(iter(field.arms)), report.counted) for field in comparison.fields}
    if comparison.common:
        most = max(field.scores(arm).max() for field in comparison.common for arm in field.arms)
        thresholds = np.linspace(0, most, THRESHOLDS)
        profiles = estimates.profiles(comparison, thresholds, np.random.default_rng(0))
        figures[estimates.ALL] = comparison_plots.over_all(
            comparison, look, pairs, base or next(iter(look)), report.rows("overall"), profiles, thresholds)
    figures["curves"] = comparison_plots.courses(comparison, look, report.counted)
    names = {env: file_name(env) for env in figures}
    for env, figure in figures.items():
        plots.save(figure, folder / "figures" / f"{names[env]}.png")
    maps = report_page.draw_best(best, folder / "figures")
    return [f"figures/{name}" for name in (*(f"{name}.png" for name in reversed(names.values())), *maps)]


def write(report: Report, folder: Path, best: dict[str, list[Run]]) -> list[str]:
    """Write figures, CSV files, a page and a LaTeX file; returns their names. best: runs for the heatmaps."""
    (folder / "figures").mkdir(parents=True, exist_ok=True)
    with workers(1) as pool:  # as long as the figures take
        film = [pool.submit(report_page.film_last_episode, runs, folder / "figures" / "film.webm")
                for runs in list(best.values())[:1]]
        pictures = draw(report, folder, best) + draw_probes(report.probes, folder)
        shown = "".join(one.result() for one in film)
    runs = list(estimates.run_rows(report.comparison, report.at))
    texts = {"comparison.md": markdown(report.command, report.notes, report.tables, pictures),
             "comparison.tex": latex(report.command, report.notes, report.tables),
             **({"runs.csv": comma_separated(runs)} if runs else {}),
             **{f"{table.name}.csv": comma_separated(table.rows) for table in report.tables}}
    if report.probes:
        texts["probe_points.csv"] = comma_separated(list(probe_estimates.point_rows(report.probes)))
    for name, text in texts.items():
        write_text(folder / name, text)
    films = {"figures/film.webm": shown} if shown else {}
    captions = {**{name: caption(name) for name in pictures}, **films}
    report_page.write(folder / "report.html", report.command, report.title, report.folders, report.notes, report.tables,
                      [Picture(folder / name, words) for name, words in captions.items()], runs)
    return ["report.html", *captions, *texts]


def caption(name: str) -> str:
    """What a figure shows, by its file name."""
    kind, _, env = Path(name).stem.partition("_")
    if kind == "probe":
        return f"{env.partition('_')[2]}: open-loop error and surprise of world models on the building's fixed probe."
    if kind == "heatmaps":
        return f"{env}: the run of each arm that covered most, visits to every cell; the blue square is the start."
    return {"curves": "Visited cells over steps; the dotted line is all there are.",
            estimates.ALL: "Over the runs of all environments."}.get(
        Path(name).stem, f"{Path(name).stem}: coverage, the area under its curve, and paired differences.")
