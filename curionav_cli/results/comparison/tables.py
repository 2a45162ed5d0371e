"""The tables of a comparison, and the pages that hold them: Markdown and LaTeX."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from curionav_cli.results import tables
from curionav_cli.results.comparison.comparison import Comparison
from curionav_cli.results.labels import differences
from curionav_cli.results.tables import Columns, Row

ARM = (("env", "env", "{}"), ("arm", "arm", "{}"), ("n", "n", "{:,}"))
ARMS = (*ARM, ("coverage", "coverage", "{:.1%}"), ("area", "area_under_curve", "{:#.3g}"))
COSTS = (
    ("CPU s", "cpu_seconds", "{:,.1f}"), ("wall s", "seconds", "{:,.1f}"), ("memory, GB", "memory", "{:.2f}"),
    ("updates", "updates", "{:,.0f}"),
    ("frames read", "frames_read", "{:,.0f}"), ("to 50 %", "steps_to_50", "{:,.0f}"),
    ("to 80 %", "steps_to_80", "{:,.0f}"), ("to 90 %", "steps_to_90", "{:,.0f}"),
    ("to 99 %", "steps_to_99", "{:,.0f}"), ("explored", "steps_to_explored", "{:,.0f}"), ("steps", "steps", "{:,}"),
)
OVERALL = (("arm", "arm", "{}"), ("runs", "n", "{:,}"), ("environments", "environments", "{:,}"),
           ("interquartile mean of the area", "interquartile_mean", "{:#.3g}"))
PAIRS = (("env", "env", "{}"), ("arm", "arm", "{}"), ("minus", "minus", "{}"), ("pairs", "n", "{:,}"),
         ("difference of the area", "difference", "{:+#.3g}"), ("p", "p", "{:.2g}"),
         ("probability of improvement", "improvement", "{:.2f}"))

RUNS = (("env", "env", "{}"), ("arm", "arm", "{}"), ("seed", "seed", "{}"), ("state", "state", "{}"),
        ("coverage", "coverage", "{:.1%}"), ("area", "area_under_curve", "{:#.3g}"), ("steps", "steps", "{:,}"),
        ("to 50 %", "steps_to_50", "{:,}"), ("to 80 %", "steps_to_80", "{:,}"), ("to 90 %", "steps_to_90", "{:,}"),
        ("to 99 %", "steps_to_99", "{:,}"), ("explored", "steps_to_explored", "{:,}"),
        ("CPU s", "cpu_seconds", "{:,.1f}"), ("memory, GB", "memory", "{:.2f}"),
        ("left out", "left_out", "{}"), ("gaps", "gaps", "{}"),
        ("error", "error", "{}"), ("folder", "folder", "{}"))
VERSIONS = (("what", "what", "{}"), ("value", "value", "{}"), ("runs", "n", "{:,}"))


class Table(NamedTuple):
    """name: of its file; title: what it shows, in a line or two."""

    name: str
    title: str
    columns: Columns
    rows: Sequence[Row]


def arm_table(rows: Sequence[Row], at: Sequence[int], counted: str) -> Table:
    """Table of what each arm reached and what it cost. at: more steps at which coverage is shown."""
    more = [(f"at {step:,}", f"coverage_at_{step}", "{:.1%}") for step in at]
    return Table("arms", f"What each arm reached, mean and 95 % t interval over seeds ({counted}). Steps to a share, "
                 "and until the agent said that nothing was left (explored): median (runs that arrived). Cost of one "
                 "run: mean.", (*ARMS, *more, *COSTS), rows)


def overall_table(rows: Sequence[Row]) -> Table:
    return Table("overall", "Over the runs of all environments that every arm has runs in, each of the same weight, "
                 "with the 95 % interval of a stratified bootstrap.", OVERALL, rows)


def pair_table(rows: Sequence[Row]) -> Table:
    return Table("pairs", "Differences between runs of the same seed: mean, 95 % t interval, two-sided p of the "
                 "sign-flip test (five pairs cannot give less than 0.062). Over all environments also the probability "
                 "that a run of arm beats one of minus, with its bootstrap interval.", PAIRS, rows)


def settings_table(comparison: Comparison) -> Table:
    """Table of the settings in which arms of one agent differ."""
    rows = []
    for agent in dict.fromkeys(comparison.arms.values()):
        same = {arm: next(run.arm for run, (_, name) in comparison.names.items() if name == arm)
                for arm, other in comparison.arms.items() if other == agent}
        rows += [{"setting": key, "arm": arm, "value": value} for key, values in differences(same).items()
                 for arm, value in values.items()]
    columns = (("setting", "setting", "{}"), ("arm", "arm", "{}"), ("value", "value", "{}"))
    return Table("settings", "Settings in which arms of one agent differ.", columns, rows)


def run_table(rows: Sequence[Row]) -> Table:
    return Table("runs", "Every run, including those that were left out.", RUNS, rows)


def version_table(rows: Sequence[Row]) -> Table:
    return Table("versions", "Versions that the runs were made with.", VERSIONS, rows)


def markdown(command: str, notes: Sequence[str], parts: Sequence[Table], figures: Sequence[str]) -> str:
    """Write the Markdown page: command, caveats, figures, tables."""
    text = [f"# Comparison\n\n`{command}`\n", *(f"- {note}" for note in notes), *(["\n"] if notes else [])]
    text += [f"![{name}]({name})" for name in figures]
    text += ["", *(tables.markdown(part.rows, part.columns, part.title) for part in parts)]
    return "\n".join(text)


def latex(command: str, notes: Sequence[str], parts: Sequence[Table]) -> str:
    """Write the tables for a paper in LaTeX; the notes as comments."""
    head = ["% \\usepackage{booktabs}", f"% {command}", *(f"% {note}" for note in notes), ""]
    return "\n".join([*head, *(tables.latex(part.rows, part.columns, part.title) for part in parts)])
