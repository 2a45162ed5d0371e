"""The paper's figures of coverage at the paper's own axes, from runs of any length: a curve ends where its run ends.

Apartments a to d (2 M steps of ours, 5 M of C-BET), the small room's run 1 and run 2 (280 k), the large lab (600 k),
and the best heatmaps side by side.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from curionav_cli.files import file_name
from curionav_cli.results import panels, plots
from curionav_cli.results.comparison.run_summaries import RunSummary
from curionav_cli.results.lettering import LINE, columns_for, wrapped
from curionav_cli.results.paper_lengths import APARTMENTS, UNTIL, Drawn
from curionav_cli.results.plots import MAXIMUM, Look
from curionav_cli.results.runs import Run
from curionav_cli.results.summary_file import opened

ALONE = {"small_room": 2, "large_lab": 1}  # environments whose figure shows our runs alone, and how many
POINTS = 400


def figures(runs: Sequence[Drawn], look: dict[str, Look]) -> Iterator[tuple[str, Figure]]:
    """Draw every figure that there are runs for; yields its name and itself."""
    for name, scenes in (("apartments", APARTMENTS), ("small_room_arms", ("small_room",)),
                         ("large_lab_arms", ("large_lab",))):
        here = [one for one in runs if one.scene in scenes]
        if here:
            yield name, curves(here, look)
    for scene, most in ALONE.items():
        ours = sorted((one for one in runs if one.scene == scene and one.ours), key=by_seed)[:most]
        if ours:
            yield scene, panels.beside([visits_of(one) for one in ours], UNTIL[scene])
    for env in dict.fromkeys(one.env for one in runs):
        yield f"best_{file_name(env)}", plots.heatmaps([visits_of(one) for one in best(runs, env)], lengths=True)


def by_seed(one: Drawn) -> str:
    return str(one.run.seed)


def best(runs: Sequence[Drawn], env: str) -> list[Drawn]:
    """The run of each arm that covered most of an environment, at its own end."""
    found: dict[str, Drawn] = {}
    for one in runs:
        if one.env == env and (one.arm not in found or len(one.run.curve.found) > len(found[one.arm].run.curve.found)):
            found[one.arm] = one
    return list(found.values())


def visits_of(one: Drawn) -> Run:
    """The run with its visits to every cell, named as in the other figures."""
    return opened(one.run.folder, variant=one.arm.removeprefix(one.run.agent), world=one.env)


def curves(runs: Sequence[Drawn], look: dict[str, Look]) -> Figure:
    """Draw a panel for each environment, and one of the mean share over them where there are several scenes."""
    envs, several = list(dict.fromkeys(one.env for one in runs)), len({one.scene for one in runs}) > 1
    count = len(envs) + several
    across, down = min(count, 4), -(-count // 4)
    figure = Figure((max(5.6, 0.6 + 3.3 * across), 1.0), layout="constrained")
    all_axes = list(figure.subplots(down, across, squeeze=False).flat)
    lines = 0
    for letter, axes, env in zip("abcdefgh", all_axes, envs):
        words = wrapped(cut_short(here := [one for one in runs if one.env == env]), 3.0 if count > 1 else 4.8)
        draw_cells(axes, here, look, words)
        axes.set_title(wrapped(f"{letter}  {env}", 2.6), loc="left")
        lines = max(lines, 1 + words.count("\n"))
    if several:
        draw_mean(all_axes[len(envs)], runs, envs, look)
        all_axes[len(envs)].set_title(f"{'abcdefgh'[len(envs)]}  over all runs", loc="left")
    for axes in all_axes[count:]:
        axes.set_axis_off()
    handles = {label: line for axes in all_axes for line, label in zip(*axes.get_legend_handles_labels())}
    columns = columns_for(figure, list(handles))
    figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=columns)
    words = "mean and range of an arm's runs up to the end of the shortest, then each; dots: ends"
    figure.suptitle(wrapped(words, figure.get_figwidth() - 0.4), fontsize=9)
    figure.set_figheight(0.5 + (3.0 + LINE * lines) * down + LINE * -(-len(handles) // columns))
    return figure


def draw_cells(axes: Axes, runs: Sequence[Drawn], look: dict[str, Look], words: str) -> None:
    """Draw visited cells and their share over the paper's steps; the number of cells is dotted. words: below them."""
    cells = runs[0].run.curve.cells
    for arm in dict.fromkeys(one.arm for one in runs):
        draw_arm(axes, arm, [one.run for one in runs if one.arm == arm], look[arm])
    until = UNTIL.get(runs[0].scene, max(one.run.steps for one in runs))
    axes.set(xlabel=f"steps\n{words}".strip(), ylabel=f"visited of {cells:,} cells", xlim=(0, until))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    plots.draw_total(axes, cells, "visitable")


def draw_arm(axes: Axes, arm: str, runs: Sequence[RunSummary], look: Look) -> None:
    """Draw an arm: the mean and the range of its runs as far as all of them go, and the end of each."""
    steps = moments(min(run.steps for run in runs))
    each = np.array([run.curve.at(steps) for run in runs])
    axes.plot(steps, each.mean(0), color=look.color, linestyle=look.dashes, linewidth=1.6, label=arm)
    axes.fill_between(steps, each.min(0), each.max(0), color=look.color, alpha=0.2, linewidth=0)
    for run in runs:
        further = moments(run.steps)[moments(run.steps) >= steps[-1]]
        axes.plot(further, run.curve.at(further), color=look.color, linestyle=look.dashes, linewidth=0.9)
        axes.plot(run.steps, run.curve.at(run.steps), ".", color=look.color, markersize=4)


def cut_short(runs: Sequence[Drawn]) -> str:
    """In words, which arms have a run that ends before the paper's curve does, and where the shortest does."""
    ends: dict[int, list[str]] = {}
    arms = dict.fromkeys(one.arm for one in runs)
    for arm in arms:
        short = [one.run.steps for one in runs if one.arm == arm and one.planned and one.run.steps < one.planned]
        if short:
            ends.setdefault(min(short), []).append(arm)
    names = {steps: ", ".join(same) if len(same) < len(arms) or len(arms) == 1 else "all arms"
             for steps, same in ends.items()}
    return "; ".join(f"{name} until {EngFormatter(sep='')(steps)}" for steps, name in names.items())


def draw_mean(axes: Axes, runs: Sequence[Drawn], envs: Sequence[str], look: dict[str, Look]) -> None:
    """Draw the mean over environments of the mean share over seeds, of arms that have runs in all of them."""
    left_out = []
    for arm in dict.fromkeys(one.arm for one in runs):
        each = [[one.run for one in runs if (one.arm, one.env) == (arm, env)] for env in envs]
        if all(each):
            steps = moments(min(run.steps for same in each for run in same))
            share = np.mean([np.mean([100 * run.curve.at(steps) / run.curve.cells for run in same], axis=0)
                             for same in each], axis=0)
            axes.plot(steps, share, color=look[arm].color, linestyle=look[arm].dashes, linewidth=1.6, label=arm)
            axes.plot(steps[-1], share[-1], ".", color=look[arm].color, markersize=4)
        else:
            left_out.append(arm)
    words = f"not in all of them: {', '.join(left_out)}" if left_out else ""
    axes.axhline(100, color=MAXIMUM, linestyle=":", linewidth=1.4)
    axes.set(xlabel=f"steps\n{wrapped(words, 3.0)}".strip(), ylabel="mean share of the cells (%)",
             ylim=(0, 100 * plots.ROOM), xlim=(0, max(UNTIL.get(one.scene, one.run.steps) for one in runs)))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))


def moments(steps: int) -> np.ndarray:
    """The steps at which a curve that ends there is drawn."""
    return np.unique(np.linspace(0, steps, POINTS + 1).astype(int))
