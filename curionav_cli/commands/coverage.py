"""curionav coverage RUN...: coverage counted again from stored poses, by any marking rule and denominator.

Beside the heatmap and the curve: the paths of a few episodes, films of some, and what the agent predicted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from curionav_cli.commands.arguments import episode_numbers, sorted_out
from curionav_cli.commands.summary import print_files, print_table
from curionav_cli.errors import ConfigError, RunFolderError
from curionav_cli.execution.screen import a_console
from curionav_cli.files import file_name, folder_for
from curionav_cli.records import Episode
from curionav_cli.results import film, learning, panels, plots
from curionav_cli.results.coverage import DENOMINATORS, RULES
from curionav_cli.results.prediction import figures as prediction_figures
from curionav_cli.results.probing import figures as probe_figures
from curionav_cli.results.runs import Run, distinguish
from curionav_cli.storage import pictures
from curionav_cli.storage.run_folder import RunFolder

CHOICES: dict[str, tuple[str, ...]] = {
    "marking": tuple(RULES), "denominator": DENOMINATORS, "episodes": (), "film": (), "out": ()}
SHOWN = ("agent", "seed", "marking", "of", "coverage", "visited", "cells", "area", "to 50 %", "to 80 %", "to 90 %",
         "to 99 %", "explored", "steps", "state", "env")
BESIDE = 4  # runs of one environment in a figure


def run(words: list[str]) -> int:
    """Print a row for every run, rule and denominator, and draw them; returns the exit code.

    words: folders of runs or sweeps, and settings of CHOICES: marking=... or denominator=... to have only that one,
    episodes=0,5,last for the paths of these episodes, film=last for films of them, out=DIR for all figures.
    """
    paths, chosen = sorted_out("coverage", words, CHOICES)
    out = folder_for(chosen["out"]) if "out" in chosen else None
    runs, lost = opened(paths)
    if not runs:
        raise ConfigError("\n".join([*lost] or ["Name the folder of a run or a sweep, as in: curionav coverage "
                                                "outputs/DATE/RUN"]))
    rules, denominators = ((chosen[key],) if key in chosen else CHOICES[key] for key in ("marking", "denominator"))
    episodes, films = ({run.folder.path: indices(key, chosen.get(key), run) for run in runs}
                       for key in ("episodes", "film"))
    for run in runs:
        for episode in films[run.folder.path]:
            pictures.refuse_thinned(run.episodes[episode])
    console = a_console()
    distinguish(runs)
    counted = {run.folder.path: [replace(run, rule=rule, denominator=of) for rule in rules for of in denominators]
               for run in runs}
    print_table([counting.row() for countings in counted.values() for counting in countings], console, SHOWN)
    for line in [*filter(None, map(prediction_figures.line, runs)), *lost, *(gap for run in runs for gap in gaps(run))]:
        console.print(line, soft_wrap=True, highlight=False, markup=False)
    for table in filter(None, map(prediction_figures.surprise_table, runs)):
        console.print(table)
    names = [run.folder.path.resolve().name for run in runs]
    for run, name in zip(runs, names):
        whole = run.folder.path.resolve()
        folder = out / (f"{whole.parent.name}_{name}" if names.count(name) > 1 else name) if out else run.folder.figures
        folder.mkdir(parents=True, exist_ok=True)
        made = [name for counting in counted[run.folder.path] for name in draw(counting, folder)]
        made += draw_episodes(run, episodes[run.folder.path], films[run.folder.path], folder)
        made += prediction_figures.draw(run, folder) + probe_figures.draw(run.folder.path, folder, (run.env, run.agent))
        made += learning.draw(run, folder)
        print_files(console, folder, made)
    firsts = [countings[0] for countings in counted.values()]
    together = draw_together(firsts, out) + prediction_figures.draw_beside(runs, out) if out else []
    for path in [*together, *prediction_figures.draw_seeds(runs, out)]:
        print_files(console, path.parent, [path.name])
    return 0


def opened(paths: Sequence[Path], denominator: str = "visitable") -> tuple[list[Run], list[str]]:
    """Every run in these folders once that has a finished episode, and a line for each of the others.

    denominator: the cells that its coverage is a share of.
    """
    runs: dict[Path, Run] = {}
    lost = []
    for path in paths:
        try:
            folders = RunFolder.found(path)
        except RunFolderError as error:
            lost.append(str(error))
            continue
        for folder in folders:
            run = Run(folder, denominator=denominator)
            try:
                if run.label and run.coverage.steps:
                    runs[folder.path.resolve()] = run
                else:
                    lost.append(f"LEFT OUT: {folder.path} has no finished episode "
                                f"({run.readable.status.get('state', 'no status')}). {run.readable.lost}".rstrip())
            except RunFolderError as error:
                lost.append(f"LEFT OUT: {error}")
    return list(runs.values()), lost


def gaps(run: Run) -> list[str]:
    """A line for each thing that is missing of a run, and one where it is not finished."""
    state = run.readable.status.get("state", "unknown")
    return [*(f"GAP: {gap}" for gap in run.readable.gaps),
            *([f"Not finished ({state}): {run.label}, {run.folder.path}"] if state != "done" else [])]


def indices(key: str, words: str | None, run: Run) -> list[int]:
    """The episodes of '0,5,9' or 'last'; by default the first, the middle and the last one, and no film.

    Raises ConfigError for anything else, and for episodes that the run does not have.
    """
    last = len(run.episodes) - 1
    if words is None:
        return sorted({0, last // 2, last}) if key == "episodes" else []
    return episode_numbers(key, words, last + 1, run.folder.path)


def draw(run: Run, folder: Path) -> list[str]:
    """Draw heatmap and curve by this rule and denominator; returns their names in the folder."""
    figures = {"heatmap": plots.heatmap(run.coverage, f"{run.label}\n{plots.share_of(run, run.denominator)}"),
               "coverage": plots.curves([run], run.label)}
    names = {kind: f"{kind}_{run.rule}_{run.denominator}.png" for kind in figures}
    for kind, figure in figures.items():
        plots.save(figure, folder / names[kind])
    return list(names.values())


def draw_episodes(run: Run, shown: Sequence[int], filmed: Sequence[int], folder: Path) -> list[str]:
    """Draw a summary of the run, the paths of some episodes and films of others; returns their names in the folder."""
    plots.save(panels.card(run, []), folder / "card.png")
    plots.save(panels.trajectories(run, shown), folder / "trajectories.png")
    names = {episode: f"episode_{episode:06d}.webm" for episode in filmed}
    for episode, name in names.items():
        film.write(film.frames(run.plan, Episode.load(run.episodes[episode]), f"episode {episode}"), folder / name)
    return ["card.png", "trajectories.png", *names.values()]


def draw_together(runs: Sequence[Run], out: Path) -> list[Path]:
    """Draw the runs of each environment: a heatmap beside their curves, as in the paper, and a summary of the first."""
    made = []
    for env in dict.fromkeys(run.env for run in runs):
        same = [run for run in runs if run.env == env]
        for kind, figure in (("beside", panels.beside(same[:BESIDE])), ("card", panels.card(same[0], same[1:]))):
            made.append(out / f"{kind}_{file_name(env)}.png")
            plots.save(figure, made[-1])
    return made
