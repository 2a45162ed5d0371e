"""Several things about a run in one picture: heatmap, curves, first-person strip, trajectories of episodes.

The paper's figures of the small room (heatmap, run 1, run 2) and of the large lab (heatmap, curve) are `beside`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from curionav_cli.files import read_arrays
from curionav_cli.records import FloorPlan
from curionav_cli.results import floor_plans, plots
from curionav_cli.results.lettering import columns_for, wrapped
from curionav_cli.results.runs import Run
from curionav_cli.results.tables import percent
from curionav_cli.storage import pictures

STRIP = 9  # frames of a first-person strip
PAST = "viridis_r"  # from pale to dark in the course of an episode, also in greyscale


def beside(runs: Sequence[Run], until: int | None = None) -> Figure:
    """Draw the first run's heatmap, then the curve of every run in a panel of its own; runs of one environment.

    until: the end of the axis of steps; each run's own end by default.
    """
    wide, _ = floor_plans.figure_size(runs[0].plan, 3.4, 1.3)
    figure = Figure((2.0 + wide + 3.6 * len(runs), 3.6), layout="constrained")
    left, *rest = figure.subplots(1, 1 + len(runs), width_ratios=[1.2 + 0.8 * wide, *[3.0] * len(runs)])
    image = plots.draw_heatmap(left, runs[0].coverage, wrapped(f"a  {runs[0].label}", 1.0 + wide),
                               int(plots.blocks(runs[0].coverage).max()))
    plots.add_scale(figure, [left], image, runs[0].coverage)
    for letter, axes, run in zip("bcdefgh", rest, runs):
        share = run.coverage.share
        reached = plots.share_of(run) if share is None else percent(share)
        title = f"{letter}  {run.agent}, seed\u00a0{run.seed}: {reached}{after(run, until)}"
        plots.draw_curves(axes, [run], wrapped(title, 2.9))
        if until:
            axes.set_xlim(0, until)
            axes.plot(run.curve.steps, run.coverage.visited, ".", color=axes.lines[0].get_color(), clip_on=False)
    return figure


def after(run: Run, until: int | None) -> str:
    """In words, where the curve of a run ends, on an axis that has an end of its own."""
    if not until:
        return ""
    cut = f" of {until:,}" if run.curve.steps < until else ""
    return f" after {run.curve.steps:,}{cut} steps"


def card(run: Run, others: Sequence[Run]) -> Figure:
    """Draw a run at a glance: heatmap, its curve and the others' (of the same environment), first-person frames.

    Without frames where the run did not keep them.
    """
    figure = Figure((8.6, 4.6), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(3.5, 1.1), squeeze=False).flat
    wide, _ = floor_plans.figure_size(run.plan, 1.6, 0.4)
    left, right = above.subplots(1, 2, width_ratios=(1.0 + wide, 3.2))
    coverage = run.coverage
    title = f"{run.label}\n{coverage.steps:,} steps, {plots.share_of(run)}"
    image = plots.draw_heatmap(left, coverage, wrapped(title, 1.8 + wide), int(plots.blocks(coverage).max()))
    plots.add_scale(above, [left], image, coverage)
    plots.draw_curves(right, [run, *others], "cells visited")
    names = right.get_legend_handles_labels()[1]
    right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=columns_for(figure, names, share=0.6),
                 columnspacing=1.2)
    newest = f"camera, episode {len(run.episodes) - 1}, by step"
    if pictures.kept(run.episodes[-1]) is not None:
        below.suptitle(f"{newest}: not kept (loop.keep)", fontsize=8)
        return figure
    step, seen = strip(run)
    for axes, number, frame in zip(below.subplots(1, STRIP), step, seen):
        axes.imshow(frame)
        axes.set_title(f"{number}", fontsize=7, pad=2)
        axes.set_axis_off()
    below.suptitle(newest, fontsize=8)
    return figure


def strip(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Steps (STRIP,) and frames (STRIP, 64, 64, 3) spread evenly over the newest episode."""
    image = read_arrays(run.episodes[-1], ("image",))["image"]
    step = np.linspace(0, len(image) - 1, STRIP).astype(int)
    return step, image[step]


def trajectories(run: Run, episodes: Sequence[int]) -> Figure:
    """Draw the path of each of these episodes over the plan, from pale at its start to dark at its end."""
    across = min(len(episodes), 4)
    down = -(-len(episodes) // across)
    wide, high = floor_plans.figure_size(run.plan, 3.4, 1.5)
    figure = Figure(((0.7 + wide) * across + 1.0, (0.8 + high) * down + 0.3), layout="constrained")
    all_axes = list(figure.subplots(down, across, squeeze=False).flat)
    for axes, episode in zip(all_axes, episodes):
        pose = read_arrays(run.episodes[episode], ("pose",))["pose"]
        floor_plans.draw_plan(axes, run.plan)
        lines = axes.add_collection(path_line(run.plan, pose))
        floor_plans.mark_places(axes, run.plan, 5.0)
        axes.plot(*floor_plans.frame(run.plan).transform(pose[-1, :2]), "o", color="#111827", markersize=4,
                  label="end of the episode", linestyle="none")
        axes.set_title(f"episode {episode}")
    for axes in all_axes[len(episodes):]:
        axes.set_axis_off()
    figure.colorbar(lines, ax=all_axes, shrink=0.8, panchor=False, label="step of the episode")
    figure.legend(*all_axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.suptitle(wrapped(run.label, figure.get_figwidth() - 0.3), fontsize=9)
    return figure


def path_line(plan: FloorPlan, pose: np.ndarray) -> LineCollection:
    """A line from pose to pose, coloured by step. pose: (T+1, 3)."""
    place = floor_plans.frame(plan).transform(pose[:, :2])
    ends = np.stack([place[:-1], place[1:]], 1)
    lines = LineCollection(list(ends), cmap=PAST, linewidths=1.2)
    lines.set_array(np.arange(len(ends)))
    return lines
