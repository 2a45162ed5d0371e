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
from curionav_cli.results import floor_plans
from curionav_cli.results.lettering import columns_for, wrapped
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
    wide, high = floor_plans.figure_size(run.plan, 3.6, 1.3)
    figure = Figure(((0.35 + wide) * across + 0.6, (0.55 + high) * down + 0.8), layout="constrained")
    panels = list(figure.subplots(down, across, squeeze=False, sharex=True, sharey=True).flat)
    for axes, number in zip(panels, range(first, len(lived))):
        draw(axes, run.plan, lived[number])
        axes.set_title(wrapped(f"{number}: {came(lived[number].dock)}", 1.2 * wide), fontsize=7)
    for axes in panels[len(lived) - first:]:
        axes.set_axis_off()
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=columns_for(figure, names))
    figure.suptitle(wrapped(f"{run.label}: true and believed path; above each how the robot came home before",
                            figure.get_figwidth() - 0.3), fontsize=9)
    return figure


def draw(axes: Axes, plan: FloorPlan, belief: Belief) -> None:
    floor_plans.draw_plan(axes, plan)
    true, believed = (floor_plans.frame(plan).transform(path[:, :2]) for path in (belief.pose, belief.estimate))
    joined = np.stack([true[::EVERY], believed[::EVERY]])  # (2, n, 2)
    axes.plot(*joined.transpose(2, 0, 1), color=APART, linewidth=0.6)
    axes.plot(*true.T, color=TRUE, linewidth=1.0, label="where it was")
    axes.plot(*believed.T, color=BELIEVED, linewidth=0.8, linestyle=(0, (3, 1)), label="where it believed to be")
    axes.plot(*true[-1], "o", color="#111827", markersize=3, label="end of the episode")
    floor_plans.mark_places(axes, plan, 5.0)


def came(dock: dict[str, Any] | None) -> str:
    """In a word or two."""
    if dock is None:
        return "first start"
    return f"{dock['code']}, carried" if dock["human"] else f"docked, attempt {dock['attempts']}"
