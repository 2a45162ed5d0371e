"""Pictures: every function takes data and returns a figure; `save` writes it, same bytes every time."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import EngFormatter

from curionav_cli.files import write_whole
from curionav_cli.records import FloorPlan
from curionav_cli.results.coverage import Coverage
from curionav_cli.results.runs import Run


class Look(NamedTuple):
    """How an arm is drawn; dashes and markers tell arms apart in greyscale."""

    color: str
    dashes: Any
    marker: str


# One look for each agent, everywhere.
STYLES = {
    "lbs_dreamer": Look("#0b5fa5", "-", "o"), "random": Look("#8a8a8a", ":", "s"),
    "sticky": Look("#b7791f", "-.", "^"), "bounce": Look("#c2410c", "--", "D"),
    "frontier": Look("#15803d", (0, (1, 1)), "v"), "cbet": Look("#be185d", (0, (5, 1)), "P"),
    "cbet_lifelong": Look("#7f1d1d", (0, (3, 1, 1, 1, 1, 1)), "X"),
}
OTHERS = (  # for agents of other names, and for all but the first arm of one agent
    Look("#6d28d9", (0, (5, 1, 1, 1)), "<"), Look("#0e7490", (0, (2, 2)), ">"), Look("#111827", (0, (7, 2, 2, 2)), "p"),
    Look("#4d7c0f", (0, (9, 3)), "*"), Look("#a21caf", (0, (4, 2, 1, 2, 1, 2)), "h"), Look("#0284c7", (0, (2, 1)), "d"),
    Look("#92400e", (0, (10, 2, 1, 2)), "8"),
)
VARIANTS = {  # of an agent's name in a label, everywhere too: which of OTHERS
    "view=ego": 1, "reward=count_oracle": 0, "reward=motion": 3, "reward=count": 5, "reward=rnd": 6, "reward=icm": 2,
    "reward=ride": 4, "curiosity=picture_count": 4, "curiosity=shuffled": 2, "curiosity=none": 6,
    "curiosity=count": 5, "curiosity=disagreement": 3, "curiosity=rnd": 0,
}
SOLID, START, MAXIMUM = "#4b5563", "#1d4ed8", "#b91c1c"
VISITS = ListedColormap(matplotlib.colormaps["inferno_r"](np.linspace(0.15, 1, 256)))  # visible on white
DRAWN = 140  # about so many squares along the longer side of a building
matplotlib.rcParams.update({
    "figure.dpi": 110, "font.size": 9, "axes.spines.top": False, "svg.hashsalt": "curionav",
    "axes.titlesize": 9, "legend.frameon": False,
})


def save(figure: Figure, path: Path) -> None:
    """PNG and PDF beside each other, finished or absent, without dates in them; their folder is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    for kind, metadata in (("png", {"Software": None}), ("pdf", {"CreationDate": None})):
        write_whole(path.with_suffix(f".{kind}"), partial(figure.savefig, format=kind, metadata=metadata))


def heatmap(coverage: Coverage, title: str) -> Figure:
    """Visits of every cell over the floor plan, on a log scale; the start is a blue square."""
    wide, high = extent_of(coverage.plan)
    figure = Figure((2.2 + 5.0 * min(1.0, wide / high), 0.9 + 5.0 * min(1.0, high / wide)), layout="constrained")
    axes = figure.add_subplot()
    draw_heatmap(axes, coverage, title, int(blocks(coverage).max()))
    add_scale(figure, [axes], coverage)
    return figure


def heatmaps(runs: Sequence[Run]) -> Figure:
    """The heatmaps of several runs side by side, on one scale."""
    most = max(int(blocks(run.coverage).max()) for run in runs)
    across = min(len(runs), 4)
    down = -(-len(runs) // across)
    wide, high = extent_of(runs[0].plan)
    size = 3.6 if wide < high else 3.0
    width = 0.6 + size * min(1.0, wide / high)
    names = [fill(f"{run.agent}, seed {run.seed}", int(width / 0.08)) for run in runs]
    height = 0.65 + 0.15 * max(1 + name.count("\n") for name in names) + size * min(1.0, high / wide)
    figure = Figure((width * across + 0.9, height * down), layout="constrained")
    all_axes = list(figure.subplots(down, across, squeeze=False).flat)
    for axes, run, name in zip(all_axes, runs, names):
        draw_heatmap(axes, run.coverage, f"{name}\n{run.coverage.share:.1%} of {run.coverage.total:,} cells", most)
    for axes in all_axes[len(runs):]:
        axes.set_axis_off()
    add_scale(figure, all_axes, runs[0].coverage)
    return figure


def draw_heatmap(axes: Axes, coverage: Coverage, title: str, most: int) -> None:
    plan = coverage.plan
    rows, columns = coverage.visits.shape
    extent = (0.0, columns * plan.cell, 0.0, rows * plan.cell)
    draw_plan(axes, plan, extent)
    visits = blocks(coverage)
    side = block_side(plan)
    axes.imshow(np.ma.masked_equal(visits, 0), norm=LogNorm(1, max(2, most)), cmap=VISITS, origin="lower",
                extent=(0, visits.shape[1] * side * plan.cell, 0, visits.shape[0] * side * plan.cell),
                interpolation="nearest")
    mark_start(axes, plan)
    axes.set(title=title, xlabel="x (m)", ylabel="y (m)")


def add_scale(figure: Figure, all_axes: Sequence[Axes], coverage: Coverage) -> None:
    figure.colorbar(all_axes[0].images[-1], ax=all_axes, shrink=0.8, label=visits_label(coverage))


def visits_label(coverage: Coverage) -> str:
    side = block_side(coverage.plan)
    return f"visits to {'a cell' if side == 1 else f'{side * side} cells'} ({coverage.rule})"


def block_side(plan: FloorPlan) -> int:
    """How many cells a drawn square is wide: more than one in a large building, so that it can be seen."""
    return max(1, round(max(extent_of(plan)) / plan.cell / DRAWN))


def blocks(coverage: Coverage) -> np.ndarray:
    """Visits summed over squares of block_side cells."""
    side = block_side(coverage.plan)
    rows, columns = coverage.visits.shape
    whole = np.pad(coverage.visits, ((0, -rows % side), (0, -columns % side)))
    return whole.reshape(whole.shape[0] // side, side, whole.shape[1] // side, side).sum((1, 3))


def extent_of(plan: FloorPlan) -> tuple[float, float]:
    """Width and height of the building in metres, without the empty border of a map."""
    used = np.argwhere(plan.floor)
    rows, columns = used.max(0) - used.min(0) + 5
    return columns * plan.cell, rows * plan.cell


def draw_plan(axes: Axes, plan: FloorPlan, extent: tuple[float, float, float, float]) -> None:
    """The plan's picture, cropped to the building."""
    axes.imshow(picture_of(plan), origin="lower", extent=extent, interpolation="nearest")
    used = np.argwhere(plan.floor)
    low, high = (used.min(0) - 2) * plan.cell, (used.max(0) + 3) * plan.cell
    axes.set_xlim(max(0, low[1]), min(extent[1], high[1]))
    axes.set_ylim(max(0, low[0]), min(extent[3], high[0]))


def picture_of(plan: FloorPlan) -> np.ndarray:
    """(rows, columns, 3): obstacles dark, cells that can be visited light, floor out of reach between."""
    picture = np.ones((*plan.floor.shape, 3))
    picture[plan.floor] = matplotlib.colors.to_rgb("#e5e7eb")
    picture[plan.visitable] = matplotlib.colors.to_rgb("#f3f4f6")
    picture[plan.solid] = matplotlib.colors.to_rgb(SOLID)
    return picture


def mark_start(axes: Axes, plan: FloorPlan) -> None:
    """A blue square."""
    half = max(plan.cell, 0.012 * max(extent_of(plan)))
    axes.add_patch(Rectangle((plan.start.x - half, plan.start.y - half), 2 * half, 2 * half,
                             facecolor=START, edgecolor="white", linewidth=0.8, zorder=3))


def looks(arms: dict[str, str]) -> dict[str, Look]:
    """A look for each arm (label -> agent): that of its variant, else the agent's own, else one that no arm has yet."""
    found: dict[str, Look] = {}
    for arm, agent in arms.items():
        variants = [OTHERS[VARIANTS[word]] for word in arm.split()[1:] if word in VARIANTS]
        free = [look for look in [*variants, *([STYLES[agent]] if agent in STYLES and not variants else []), *OTHERS]
                if look not in found.values()]
        found[arm] = free[0] if free else OTHERS[len(found) % len(OTHERS)]
    return found


def curves(runs: Sequence[Run], title: str) -> Figure:
    """Visited cells (left) and their share (right) over steps, the number of cells as a dotted line."""
    figure = Figure((6.4, 3.8), layout="constrained")
    draw_curves(figure.add_subplot(), runs, title)
    figure.legend(loc="outside lower center", ncols=5)
    return figure


def draw_curves(axes: Axes, runs: Sequence[Run], title: str) -> None:
    """Both scales into one panel; each agent is named once."""
    look = looks({run.agent: run.config["agent"]["name"] for run in runs})
    named: set[str] = set()
    for run in runs:
        colour, dashes, _ = look[run.agent]
        steps = np.unique(np.concatenate([run.curve.found, np.linspace(0, run.curve.steps, 400).astype(int)]))
        axes.plot(steps, run.curve.at(steps), color=colour, linestyle=dashes, linewidth=1.6,
                  label=None if run.agent in named else run.agent)
        named.add(run.agent)
    total = max(run.coverage.total for run in runs)
    axes.axhline(total, color=MAXIMUM, linestyle=":", linewidth=1.4)
    axes.annotate(f"{total:,} {runs[0].denominator} cells", (0.01, total), xycoords=("axes fraction", "data"),
                  xytext=(0, -11), textcoords="offset points", color=MAXIMUM)
    axes.set(title=title, xlabel="steps", ylabel=f"visited cells ({runs[0].rule})", ylim=(0, total * 1.04),
             xlim=(0, max(run.curve.steps for run in runs)))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    percent = 100 / total
    share = axes.secondary_yaxis("right", functions=(partial(np.multiply, percent), partial(np.multiply, 1 / percent)))
    share.set_ylabel(f"share of {runs[0].denominator} cells (%)")
