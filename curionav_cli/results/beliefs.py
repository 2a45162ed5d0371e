"""Where a robot that drifts believed to be, beside where it was: a panel an episode, over the floor plan."""

from __future__ import annotations

import json
import math
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from curionav_cli.files import read_arrays
from curionav_cli.records import FloorPlan
from curionav_cli.results import plots
from curionav_cli.results.runs import Run

TRUE, BELIEVED, APART = "#0b5fa5", "#c2410c", "#9ca3af"
MOST, ACROSS = 20, 10  # panels in all, and in a row
EVERY = 25  # steps between the lines that join the two


class Belief(NamedTuple):
    """One episode: pose and estimate (T+1, 3), and the homecoming before it."""

    pose: np.ndarray
    estimate: np.ndarray
    dock: dict[str, Any] | None


def beliefs(run: Run) -> list[Belief]:
    """Of every episode; none where the robot is ideal. Raises RunFolderError where a file is broken."""
    arrays = [read_arrays(path, ("pose",), ("estimate", "dock")) for path in run.episodes]
    return [Belief(one["pose"], one["estimate"], json.loads(str(one["dock"]))) for one in arrays if "estimate" in one]


def paths(run: Run) -> Figure | None:
    """True and believed path of the newest episodes; None where the robot is ideal."""
    lived = beliefs(run)
    if not lived:
        return None
    first = max(0, len(lived) - MOST)
    across = min(ACROSS, len(lived) - first)
    down = math.ceil((len(lived) - first) / across)
    wide, high = plots.extent_of(run.plan)
    size = 3.6 / max(wide, high)
    figure = Figure(((0.35 + size * wide) * across + 0.6, (0.55 + size * high) * down + 0.5), layout="constrained")
    panels = list(figure.subplots(down, across, squeeze=False, sharex=True, sharey=True).flat)
    for axes, number in zip(panels, range(first, len(lived))):
        draw(axes, run.plan, lived[number])
        axes.set_title(f"{number}: {came(lived[number].dock)}", fontsize=7)
    for axes in panels[len(lived) - first:]:
        axes.set_axis_off()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.suptitle(f"{run.label}: true and believed path; above each how the robot came home before", fontsize=9)
    return figure


def draw(axes: Axes, plan: FloorPlan, belief: Belief) -> None:
    rows, columns = plan.floor.shape
    plots.draw_plan(axes, plan, (0.0, columns * plan.cell, 0.0, rows * plan.cell))
    joined = np.stack([belief.pose[::EVERY, :2], belief.estimate[::EVERY, :2]])  # (2, n, 2)
    axes.plot(*joined.transpose(2, 0, 1), color=APART, linewidth=0.6)
    axes.plot(belief.pose[:, 0], belief.pose[:, 1], color=TRUE, linewidth=1.0, label="where it was")
    axes.plot(belief.estimate[:, 0], belief.estimate[:, 1], color=BELIEVED, linewidth=0.8, linestyle=(0, (3, 1)),
              label="where it believed to be")
    axes.plot(*belief.pose[-1, :2], "o", color="#111827", markersize=3, label="end of the episode")
    plots.mark_start(axes, plan)


def came(dock: dict[str, Any] | None) -> str:
    """In a word or two."""
    if dock is None:
        return "first start"
    return f"{dock['code']}, carried" if dock["human"] else f"docked, attempt {dock['attempts']}"
