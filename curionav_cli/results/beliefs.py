"""True and estimated path of a robot whose odometry drifts: a panel an episode, over the floor plan.

Of a real robot nothing measures the true path: the estimate stands for both, and is drawn alone.
"""

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

TRUE, ESTIMATED, APART = "#0b5fa5", "#c2410c", "#9ca3af"
MOST, ACROSS = 20, 10  # panels in all, and in a row
EVERY = 25  # steps between the lines that join the two


class Track(NamedTuple):
    """One episode: true poses and estimates (T+1, 3), metres and radians, and the return to dock before it."""

    pose: np.ndarray
    estimate: np.ndarray
    dock: dict[str, Any] | None

    @property
    def measured(self) -> bool:
        """Whether the true path is known."""
        return not np.array_equal(self.pose, self.estimate)


def tracks(run: Run) -> list[Track]:
    """The tracks of all episodes; none where the robot is ideal. Raises RunFolderError where a file is broken."""
    arrays = [read_arrays(path, ("pose",), ("estimate", "dock")) for path in run.episodes]
    return [Track(episode["pose"], episode["estimate"], json.loads(str(episode["dock"])))
            for episode in arrays if "estimate" in episode]


def paths(run: Run) -> Figure | None:
    """Draw true and estimated path of the newest episodes; None where the robot is ideal."""
    found = tracks(run)
    if not found:
        return None
    first = max(0, len(found) - MOST)
    across = min(ACROSS, len(found) - first)
    down = math.ceil((len(found) - first) / across)
    wide, high = floor_plans.figure_size(run.plan, 3.6, 1.3)
    figure = Figure(((0.35 + wide) * across + 0.6, (0.55 + high) * down + 0.8), layout="constrained")
    panels = list(figure.subplots(down, across, squeeze=False, sharex=True, sharey=True).flat)
    for axes, number in zip(panels, range(first, len(found))):
        draw(axes, run.plan, found[number])
        axes.set_title(wrapped(f"{number}: {arrival(found[number].dock)}", 1.2 * wide), fontsize=7)
    for axes in panels[len(found) - first:]:
        axes.set_axis_off()
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=columns_for(figure, names))
    what = "true and estimated path" if any(track.measured for track in found) else "estimated path"
    figure.suptitle(wrapped(f"{run.label}: {what}; above each the return to dock before it",
                            figure.get_figwidth() - 0.3), fontsize=9)
    return figure


def draw(axes: Axes, plan: FloorPlan, track: Track) -> None:
    floor_plans.draw_plan(axes, plan)
    true, estimated = (floor_plans.frame(plan).transform(path[:, :2]) for path in (track.pose, track.estimate))
    if track.measured:
        joined = np.stack([true[::EVERY], estimated[::EVERY]])  # (2, n, 2)
        axes.plot(*joined.transpose(2, 0, 1), color=APART, linewidth=0.6)
        axes.plot(*true.T, color=TRUE, linewidth=1.0, label="true path")
    axes.plot(*estimated.T, color=ESTIMATED, linewidth=0.8, linestyle=(0, (3, 1)), label="estimated path")
    axes.plot(*true[-1], "o", color="#111827", markersize=3, label="end of the episode")
    floor_plans.mark_places(axes, plan, 5.0)


def arrival(dock: dict[str, Any] | None) -> str:
    """How a return to dock ended, in a word or two."""
    if dock is None:
        return "first start"
    return f"{dock['code']}, carried" if dock["human"] else f"docked, attempt {dock['attempts']}"
