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
from curionav_cli.results import plots
from curionav_cli.results.runs import Run

STRIP = 9  # frames of a first-person strip
PAST = "viridis_r"  # from pale to dark in the course of an episode, also in greyscale


def beside(runs: Sequence[Run]) -> Figure:
    """The first run's heatmap, then the curve of every run in a panel of its own; runs of one environment."""
    wide, high = plots.extent_of(runs[0].plan)
    ratios = [1.2 + 2.6 * min(1.0, wide / high), *[3.0] * len(runs)]
    figure = Figure((2.0 + 3.4 * min(1.0, wide / high) + 3.6 * len(runs), 3.6), layout="constrained")
    left, *rest = figure.subplots(1, 1 + len(runs), width_ratios=ratios)
    plots.draw_heatmap(left, runs[0].coverage, f"a  {runs[0].label}", int(plots.blocks(runs[0].coverage).max()))
    plots.add_scale(figure, [left], runs[0].coverage)
    for letter, axes, run in zip("bcdefgh", rest, runs):
        plots.draw_curves(axes, [run], f"{letter}  {run.agent}, seed {run.seed}: {run.coverage.share:.1%}")
    return figure


def card(run: Run, others: Sequence[Run]) -> Figure:
    """The run at a glance: its heatmap beside its curve (and the others', of the same environment) above its camera."""
    figure = Figure((8.6, 4.6), layout="constrained")
    above, below = figure.subfigures(2, 1, height_ratios=(3.5, 1.1), squeeze=False).flat
    wide, high = plots.extent_of(run.plan)
    left, right = above.subplots(1, 2, width_ratios=(1.0 + 1.6 * min(1.0, wide / high), 3.2))
    coverage = run.coverage
    plots.draw_heatmap(left, coverage, f"{run.label}\n{coverage.steps:,} steps, {coverage.share:.1%} of "
                       f"{coverage.total:,} cells", int(plots.blocks(coverage).max()))
    above.colorbar(left.images[-1], ax=left, shrink=0.8, label=plots.visits_label(coverage))
    plots.draw_curves(right, [run, *others], "cells visited")
    right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=5, columnspacing=1.2)
    step, image = strip(run)
    for axes, number, frame in zip(below.subplots(1, STRIP), step, image):
        axes.imshow(frame)
        axes.set_title(f"{number}", fontsize=7, pad=2)
        axes.set_axis_off()
    below.suptitle(f"what the robot sees, episode {len(run.episodes) - 1}, by step", fontsize=8)
    return figure


def strip(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Steps (STRIP,) and frames (STRIP, 64, 64, 3) spread evenly over the newest episode."""
    image = read_arrays(run.episodes[-1], ("image",))["image"]
    step = np.linspace(0, len(image) - 1, STRIP).astype(int)
    return step, image[step]


def trajectories(run: Run, episodes: Sequence[int]) -> Figure:
    """The way of each of these episodes over the plan, from pale at its start to dark at its end."""
    across = min(len(episodes), 4)
    down = -(-len(episodes) // across)
    wide, high = plots.extent_of(run.plan)
    size = 3.4 / max(wide, high)
    figure = Figure(((0.7 + size * wide) * across + 1.0, (0.8 + size * high) * down), layout="constrained")
    all_axes = list(figure.subplots(down, across, squeeze=False).flat)
    for axes, episode in zip(all_axes, episodes):
        pose = read_arrays(run.episodes[episode], ("pose",))["pose"]
        rows, columns = run.plan.floor.shape
        plots.draw_plan(axes, run.plan, (0.0, columns * run.plan.cell, 0.0, rows * run.plan.cell))
        lines = axes.add_collection(way(run.plan, pose))
        plots.mark_start(axes, run.plan)
        axes.plot(*pose[-1, :2], "o", color="#111827", markersize=4)
        axes.set(title=f"episode {episode}", xlabel="x (m)", ylabel="y (m)")
    for axes in all_axes[len(episodes):]:
        axes.set_axis_off()
    figure.colorbar(lines, ax=all_axes, shrink=0.8, label="step of the episode")
    figure.suptitle(run.label, fontsize=9)
    return figure


def way(plan: FloorPlan, pose: np.ndarray) -> LineCollection:
    """A line from pose to pose, coloured by step. pose: (T+1, 3)."""
    ends = np.stack([pose[:-1, :2], pose[1:, :2]], 1)
    lines = LineCollection(list(ends), cmap=PAST, linewidths=1.2)
    lines.set_array(np.arange(len(ends)))
    return lines
