"""curionav paper figures RUN... and curionav paper changes RUN...: from runs of any length, also unfinished ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from curionav_cli.commands.coverage import gaps, opened
from curionav_cli.commands.summary import print_columns, print_files, write_text
from curionav_cli.errors import ConfigError
from curionav_cli.files import file_name
from curionav_cli.results import (
    change_ages,
    change_pairs,
    change_plots,
    changes,
    page_blocks,
    paper_figures,
    paper_kept,
    paper_lengths,
    paper_page,
    plots,
    tables,
    verdicts,
)
from curionav_cli.results.comparison.comparison import TWICE, compare
from curionav_cli.results.comparison.parallel import jobs_in
from curionav_cli.results.comparison.tables import Table
from curionav_cli.results.paper_lengths import Drawn
from curionav_cli.results.runs import distinguish
from curionav_cli.results.tables import Row

NAME_RUNS = "There is no run to read. Name folders of runs or sweeps, as in: curionav paper {} outputs/DATE/SWEEP"
NO_PAIR = ("What change costs is not shown: no two of these runs have the same agent and seed, one with "
           "env.changes=true and one with env.changes=false.")

ALL_COLUMNS = {  # of each table of `figures`, also where no row knows anything of them
    "verdicts": verdicts.COLUMNS, "against": verdicts.AGAINST_COLUMNS, "arms": paper_lengths.ARM_COLUMNS,
    "coverage": paper_lengths.COVERAGE_COLUMNS, "runs": paper_lengths.RUN_COLUMNS}
VERDICTS = (
    "The paper's claims by the rules of docs/paper-length.md: our numbers up to where the runs go, and a verdict; not "
    "decided where what is missing of the declared runs could still change it. Of these runs alone: where it would be "
    "another one had no other run been declared.")


def run(what: str, folders: Sequence[Path], out: Path, console: Console, command: str, pages: Sequence[Path],
        keep: bool = False) -> int:
    """Draw and write what one of `figures` and `changes` is; returns the exit code.

    command: the line that was typed. pages: Markdown pages whose blocks get the tables, instead of a page in out.
    keep: what stands in out of other worlds than those of the runs stays, as `figures` has it.
    """
    before = {page: page_blocks.opened(page, what, paper_page.NAMES[what]) for page in pages}
    made, parts, lost = figures(folders, out, keep) if what == "figures" else effects(folders, out)
    for part in parts:
        print_columns(part.rows, part.columns, console, [heading for heading, _, _ in part.columns], part.title)
        write_text(out / f"{part.name}.csv", tables.comma_separated(part.rows))
    if not pages:
        made.append(f"{what}.md")
        write_text(out / made[-1], "\n".join(tables.markdown(part.rows, part.columns, part.title) for part in parts))
    for page, text in before.items():
        drawn = paper_page.pictures(made, out, page.parent)
        page_blocks.written(page, page_blocks.filled(text, paper_page.blocks(what, command, parts, drawn)))
    for line in [*lost, *(f"{page}: its blocks are written anew." for page in pages)]:
        console.print(line, soft_wrap=True, highlight=False, markup=False)
    print_files(console, out, [*made, *(f"{part.name}.csv" for part in parts)])
    return 0


def figures(folders: Sequence[Path], out: Path, keep: bool = False) -> tuple[list[str], list[Table], list[str]]:
    """The paper's figures of coverage, its claims with their verdicts, what each run covered and cost, and a line about
    each run that cannot be shown. keep: with tables and pictures of other worlds that are in out."""
    runs, lost = paper_lengths.read_learning(folders)
    if not runs:
        raise ConfigError("\n".join([*lost, NAME_RUNS.format("figures")]))
    out.mkdir(parents=True, exist_ok=True)
    comparison = compare(runs)
    shown, made = paper_lengths.drawn(comparison), []
    everyone, read = paper_lengths.named(comparison), {run.folder.resolve() for run in runs}
    rows = [*paper_lengths.rows(everyone),
            *paper_lengths.begun_only([job for whole, job in jobs_in(folders)[0].items() if whole not in read])]
    unfinished = [f"Not finished ({row['state']}): {row['env']}, {row['arm']}, seed {row['seed']}, {row['steps']:,} "
                  "steps; its curve ends there." for row in rows if row["state"] != "done"]
    second = [f"Not drawn: {run.folder}, {reason}." for run, reason in comparison.left_out.items()
              if TWICE in reason]
    parts, scenes = [*claims(shown), *tables_of(shown, everyone, rows)], {one.scene for one in everyone}
    if keep:  # before anything is drawn: a table that cannot be read leaves all as it is
        parts = [paper_kept.merged(part, ALL_COLUMNS[part.name], out, scenes) for part in parts]
    for name, figure in paper_figures.figures(shown, plots.looks({one.arm: one.run.agent for one in shown})):
        plots.save(figure, out / f"{name}.png")
        made.append(f"{name}.png")
    if keep:
        made = paper_kept.pictures(out, made, scenes)
    return made, [part for part in parts if part.rows], [
        *unfinished, *second, *(paper_kept.apartments_line(parts, scenes) if keep else ()),
        *(f"GAP: {gap}" for run in runs for gap in run.gaps), *lost]


def claims(shown: Sequence[Drawn]) -> list[Table]:
    """Tables of verdicts, and of differences at equal steps."""
    return [Table("verdicts", VERDICTS, verdicts.COLUMNS, verdicts.rows(shown)),
            Table("against", "Ours beside what does not learn and beside its control, at equal steps; means of runs.",
                  verdicts.AGAINST_COLUMNS, verdicts.against(shown))]


def tables_of(shown: Sequence[Drawn], everyone: Sequence[Drawn], rows: Sequence[Row]) -> list[Table]:
    """Tables of coverage at the reported steps, of arms and of runs, and of the runs themselves."""
    columns = tables.known(paper_lengths.COVERAGE_COLUMNS, covered := paper_lengths.coverages(everyone))
    arms = paper_lengths.arm_coverages(shown)
    return [Table("arms", "Coverage after these steps, mean of the runs and their range; n: runs.",
                  tables.known(paper_lengths.ARM_COLUMNS, arms), arms),
            Table("coverage", "Coverage after these steps, and area under the curve up to the end of each run.",
                  columns, covered),
            Table("runs", "One row a run; the paper's: steps at which its curve ends.",
                  tables.known(paper_lengths.RUN_COLUMNS, rows), rows)]


def effects(folders: Sequence[Path], out: Path) -> tuple[list[str], list[Table], list[str]]:
    """What moved objects do to surprise and coverage, a figure for each environment, and a line about runs left out."""
    runs, lost = opened(folders, "floor")
    if not runs:
        raise ConfigError("\n".join([*lost, NAME_RUNS.format("changes")]))
    distinguish(runs)
    found, alone = changes.pairs(runs)
    notes = [*(line for run in runs for line in gaps(run)), *alone, *lost]
    if not found:
        raise ConfigError("\n".join([*notes, "Nothing moved in any of these runs. Give one with "
                                              "env.changes=true, of a world in which things move."]))
    out.mkdir(parents=True, exist_ok=True)
    made = []
    for scene in dict.fromkeys(one.run.config["env"]["name"] for one in found):
        here = [one for one in found if one.run.config["env"]["name"] == scene]
        made.append(f"changes_{file_name(scene)}.png")
        plots.save(change_plots.figure(here, scene), out / made[-1])
    rows, aged = change_pairs.rows(found), change_ages.rows(found)
    parts = [Table("change_pairs", change_pairs.BELOW, tables.known(change_pairs.COLUMNS, rows), rows),
             Table("change_ages", change_ages.BELOW, tables.known(change_ages.COLUMNS, aged), aged),
             Table("changes", changes.BELOW, changes.COLUMNS, [changes.summary(one) for one in found]),
             Table("surprise_by_age", "Surprise near what moved, by the age of the move.", changes.AGE_COLUMNS,
                   [row for one in found for row in changes.age_rows(one)])]
    return made, [part for part in parts if part.rows], [*([] if rows else [NO_PAIR]), *notes]
