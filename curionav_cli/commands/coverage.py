"""curionav coverage RUN...: coverage counted again from stored poses, by any marking rule and denominator.

Beside the heatmap and the curve: the ways of a few episodes, one of them as a film, and what the agent predicted.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from curionav_cli.commands.arguments import sorted_out
from curionav_cli.commands.summary import print_files, print_table
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import file_name, folder_for
from curionav_cli.records import Episode
from curionav_cli.results import film, panels, plots, tables
from curionav_cli.results.coverage import DENOMINATORS, RULES
from curionav_cli.results.prediction import figures as prediction_figures
from curionav_cli.results.runs import Run, distinguish
from curionav_cli.storage.run_folder import RunFolder

CHOICES: dict[str, tuple[str, ...]] = {
    "marking": tuple(RULES), "denominator": DENOMINATORS, "episodes": (), "film": (), "out": ()}
SHOWN = ("agent", "seed", "marking", "of", "coverage", "visited", "cells", "area", "to 50 %", "to 80 %", "to 90 %",
         "steps", "state", "env")
BESIDE = 4  # runs of one environment in a figure


def run(words: list[str]) -> int:
    """Print a row for every run, rule and denominator, and draw them; the exit code.

    words: folders of runs or sweeps, and settings out of CHOICES: marking=... or denominator=... to have only those,
    episodes=0,5,last for the ways of these episodes, film=last for films of them, out=DIR for all figures.
    """
    paths, chosen = sorted_out("coverage", words, CHOICES)
    out = folder_for(chosen["out"]) if "out" in chosen else None
    runs, lost = opened(paths)
    if not runs:
        raise ConfigError("\n".join([*lost] or ["Name the folder of a run or a sweep, as in: curionav coverage "
                                                "outputs/DATE/RUN"]))
    rules, denominators = ((chosen[key],) if key in chosen else CHOICES[key] for key in ("marking", "denominator"))
    episodes, films = ({one.folder.path: indices(key, chosen.get(key), one) for one in runs}
                       for key in ("episodes", "film"))
    console = a_console()
    distinguish(runs)
    counted = {one.folder.path: [replace(one, rule=rule, denominator=of) for rule in rules for of in denominators]
               for one in runs}
    print_table([way.row() for ways in counted.values() for way in ways], console, SHOWN)
    for line in [*filter(None, map(prediction_figures.line, runs)), *lost, *(gap for one in runs for gap in gaps(one))]:
        console.print(line, soft_wrap=True, highlight=False, markup=False)
    for table in filter(None, map(prediction_figures.surprise_table, runs)):
        console.print(table)
    names = [one.folder.path.resolve().name for one in runs]
    for one, name in zip(runs, names):
        whole = one.folder.path.resolve()
        folder = out / (f"{whole.parent.name}_{name}" if names.count(name) > 1 else name) if out else one.folder.figures
        folder.mkdir(parents=True, exist_ok=True)
        made = [name for way in counted[one.folder.path] for name in draw(way, folder)]
        made += draw_episodes(one, episodes[one.folder.path], films[one.folder.path], folder)
        made += prediction_figures.draw(one, folder)
        print_files(console, folder, made)
    together = draw_together([ways[0] for ways in counted.values()], out) + prediction_figures.draw_beside(runs, out) \
        if out else []
    for path in [*together, *prediction_figures.draw_seeds(runs, out)]:
        print_files(console, path.parent, [path.name])
    return 0


def opened(paths: Sequence[Path]) -> tuple[list[Run], list[str]]:
    """Every run in these folders once that anything can be shown of, and a line for each of the others."""
    runs: dict[Path, Run] = {}
    lost = []
    for path in paths:
        try:
            folders = RunFolder.found(path)
        except RunFolderError as error:
            lost.append(str(error))
            continue
        for folder in folders:
            one = Run(folder)
            try:
                if one.label and one.coverage.steps:
                    runs[folder.path.resolve()] = one
                else:
                    lost.append(f"LEFT OUT: {folder.path} has no finished episode "
                                f"({one.readable.status.get('state', 'no status')}). {one.readable.lost}".rstrip())
            except RunFolderError as error:
                lost.append(f"LEFT OUT: {error}")
    return list(runs.values()), lost


def gaps(one: Run) -> list[str]:
    """What is missing of a run, and whether it is still to be finished, a line each."""
    state = one.readable.status.get("state", "unknown")
    return [*(f"GAP: {gap}" for gap in one.readable.gaps),
            *([f"Not finished ({state}): {one.label}, {one.folder.path}"] if state != "done" else [])]


def indices(key: str, words: str | None, one: Run) -> list[int]:
    """The episodes that '0,5,9' or 'last' names; without words the first, the middle and the last one, and no film.

    Raises ConfigError for what is no list, and for episodes that the run does not have.
    """
    last = len(one.episodes) - 1
    if words is None:
        return sorted({0, last // 2, last}) if key == "episodes" else []
    if not re.fullmatch(r"(\d+|last)(,(\d+|last))*", words):
        raise ConfigError(f"{key}: {words!r} is not a list of episodes, as in {key}=0,5,last")
    found = sorted({last if word == "last" else int(word) for word in words.split(",")})
    if found[-1] > last:
        raise ConfigError(f"{one.folder.path} has no episode {found[-1]}: it has 0 to {last}.")
    return found


def draw(one: Run, folder: Path) -> list[str]:
    """Heatmap and curve by this rule and denominator; their names in the folder."""
    share = f"{tables.percent(one.coverage.share)} of {one.coverage.total:,} {one.denominator} cells"
    figures = {"heatmap": plots.heatmap(one.coverage, f"{one.label}\n{share}"),
               "coverage": plots.curves([one], one.label)}
    names = {kind: f"{kind}_{one.rule}_{one.denominator}.png" for kind in figures}
    for kind, figure in figures.items():
        plots.save(figure, folder / names[kind])
    return list(names.values())


def draw_episodes(one: Run, shown: Sequence[int], filmed: Sequence[int], folder: Path) -> list[str]:
    """The run at a glance, the ways of some episodes and films of others; their names in the folder."""
    plots.save(panels.card(one, []), folder / "card.png")
    plots.save(panels.trajectories(one, shown), folder / "trajectories.png")
    names = {episode: f"episode_{episode:06d}.webm" for episode in filmed}
    for episode, name in names.items():
        film.write(film.frames(one.plan, Episode.load(one.episodes[episode]), f"episode {episode}"), folder / name)
    return ["card.png", "trajectories.png", *names.values()]


def draw_together(runs: Sequence[Run], out: Path) -> list[Path]:
    """The runs of each environment: a heatmap beside their curves, as in the paper, and the first one at a glance."""
    made = []
    for env in dict.fromkeys(run.env for run in runs):
        same = [run for run in runs if run.env == env]
        for kind, figure in (("beside", panels.beside(same[:BESIDE])), ("card", panels.card(same[0], same[1:]))):
            made.append(out / f"{kind}_{file_name(env)}.png")
            plots.save(figure, made[-1])
    return made
