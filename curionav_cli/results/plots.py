"""Figures of runs: every function takes data and returns a figure; `save` writes it, same bytes every time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure, SubFigure
from matplotlib.image import AxesImage
from matplotlib.ticker import EngFormatter, NullFormatter, StrMethodFormatter

from curionav_cli.files import write_whole
from curionav_cli.records import FloorPlan
from curionav_cli.results import floor_plans
from curionav_cli.results.coverage import Coverage
from curionav_cli.results.lettering import LINE, columns_for, settle, wrapped
from curionav_cli.results.runs import Run
from curionav_cli.results.tables import covered


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
    "cbet_lifelong": Look("#7f1d1d", (0, (3, 1, 1, 1, 1, 1)), "X"), "mapper": Look("#0f766e", (0, (6, 1, 3, 1)), "H"),
    "curious_mapper": Look("#1e3a8a", (0, (8, 1, 2, 1)), "x"),
}
OTHERS = (  # for agents of other names, and for all but the first arm of one agent
    Look("#6d28d9", (0, (5, 1, 1, 1)), "<"), Look("#0e7490", (0, (2, 2)), ">"), Look("#111827", (0, (7, 2, 2, 2)), "p"),
    Look("#4d7c0f", (0, (9, 3)), "*"), Look("#a21caf", (0, (4, 2, 1, 2, 1, 2)), "h"), Look("#0284c7", (0, (2, 1)), "d"),
    Look("#92400e", (0, (10, 2, 1, 2)), "8"),
)
VARIANTS = {  # of an agent's name in a label, everywhere too: which of OTHERS
    "view=ego": 1, "reward=count_oracle": 0, "reward=motion": 3, "reward=count": 5, "reward=rnd": 6, "reward=icm": 2,
    "reward=ride": 4, "curiosity=picture_count": 4, "curiosity=shuffled": 2, "curiosity=none": 6,
    "curiosity=count": 5, "curiosity=disagreement": 3, "curiosity=rnd": 0, "curiosity=lbs_count": 1,
    "surprise=shuffled": 2, "surprise=visits": 4,
}
MAXIMUM = "#b91c1c"
ROOM = 1.12  # of an axis of cells, for the words above their number
VISITS = ListedColormap(matplotlib.colormaps["inferno_r"](np.linspace(0.15, 1, 256)))  # visible on white
DRAWN = 140  # about so many squares along the longer side of a building
matplotlib.rcParams.update({
    "figure.dpi": 110, "font.size": 9, "axes.spines.top": False, "svg.hashsalt": "curionav",
    "axes.titlesize": 9, "legend.frameon": False, "legend.fontsize": 8,
    "text.parse_math": False,  # a map may be called a$b$c
})


def save(figure: Figure, path: Path) -> None:
    """Write PNG and PDF beside each other, finished or absent, without dates in them; their folder is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    settle(figure)
    with laid_out(figure):
        for kind, metadata in (("png", {"Software": None}), ("pdf", {"CreationDate": None})):
            write_whole(path.with_suffix(f".{kind}"), partial(figure.savefig, format=kind, metadata=metadata))


@contextmanager
def laid_out(figure: Figure) -> Iterator[None]:
    """Place what is in a figure once, by its letters on a PNG; savefig would draw all of it once more for each file."""
    engine = figure.get_layout_engine()
    if engine is not None:
        FigureCanvasAgg(figure)
        engine.execute(figure)
    figure.set_layout_engine(None)
    yield
    figure.set_layout_engine(engine)


def heatmap(coverage: Coverage, title: str) -> Figure:
    """Draw visits of every cell over the floor plan, on a log scale; start and dock are marked."""
    plan = coverage.plan
    wide, high = floor_plans.figure_size(plan, 5.0, 2.4)
    lines = wrapped(title, 2.0 + wide)
    margins = 2.0 + LINE * lines.count("\n") + 0.5 * (wide > 5 * high)
    figure = Figure((2.2 + wide, margins + high), layout="constrained")
    axes = figure.add_subplot()
    image = draw_heatmap(axes, coverage, "", int(blocks(coverage).max()))
    floor_plans.add_scale_bar(axes, plan)
    add_scale(figure, [axes], image, coverage)
    floor_plans.add_legend(figure, floor_plans.meanings(axes, plan))
    figure.suptitle(lines, fontsize=9)
    return figure


def heatmaps(runs: Sequence[Run], lengths: bool = False) -> Figure:
    """Draw the heatmaps of several runs side by side, on one scale. lengths: with the steps of each."""
    most = max(int(blocks(run.coverage).max()) for run in runs)
    across = min(len(runs), 4)
    down = -(-len(runs) // across)
    wide, high = floor_plans.figure_size(runs[0].plan, 3.4, 1.6)
    width = 0.6 + wide
    after = [f"\nafter {run.coverage.steps:,} steps" if lengths else "" for run in runs]
    names = [wrapped(f"{run.agent}, seed\u00a0{run.seed}\n{share_of(run)}{words}", width)
             for run, words in zip(runs, after)]
    height = 0.65 + 0.15 * max(1 + name.count("\n") for name in names) + high
    figure = Figure((width * across + 1.2, height * down), layout="constrained")
    all_axes = list(figure.subplots(down, across, squeeze=False).flat)
    images = [draw_heatmap(axes, run.coverage, name, most) for axes, run, name in zip(all_axes, runs, names)]
    for axes in all_axes[len(runs):]:
        axes.set_axis_off()
    add_scale(figure, all_axes, images[0], runs[0].coverage)
    return figure


def draw_heatmap(axes: Axes, coverage: Coverage, title: str, most: int) -> AxesImage:
    """Draw plan, visits (the image that is returned) and above them the walls, which large squares would hide."""
    plan, visits = coverage.plan, blocks(coverage)
    floor_plans.draw_plan(axes, plan)
    image = floor_plans.draw_grid(axes, plan, np.ma.masked_equal(visits, 0), block_side(plan), cmap=VISITS,
                                  norm=LogNorm(1, max(2, most)), zorder=1)
    floor_plans.draw_plan(axes, plan, walls_only=True)
    floor_plans.mark_places(axes, plan)
    axes.set_title(title)
    return image


def add_scale(figure: Figure | SubFigure, all_axes: Sequence[Axes], image: AxesImage, coverage: Coverage) -> None:
    """Add the colour scale: right of the plans, below those of corridors."""
    wide, high = floor_plans.size_of(coverage.plan)
    bar = figure.colorbar(image, ax=all_axes, shrink=0.8, label=visits_label(coverage), panchor=False,
                          location="bottom" if wide > 5 * high else "right", format=StrMethodFormatter("{x:,.0f}"))
    bar.long_axis.set_minor_formatter(NullFormatter())


def visits_label(coverage: Coverage) -> str:
    side = block_side(coverage.plan)
    return f"visits to {'a cell' if side == 1 else f'{side * side} cells'} ({coverage.rule})"


def block_side(plan: FloorPlan) -> int:
    """Cells on a side of a drawn square: more than one in a large building, so that it can be seen."""
    longest = max(part.stop - part.start for part in floor_plans.window(plan))
    return max(1, round(longest / DRAWN))


def blocks(coverage: Coverage) -> np.ndarray:
    """Visits summed over squares of block_side cells."""
    side = block_side(coverage.plan)
    rows, columns = coverage.visits.shape
    whole = np.pad(coverage.visits, ((0, -rows % side), (0, -columns % side)))
    return whole.reshape(whole.shape[0] // side, side, whole.shape[1] // side, side).sum((1, 3))


def looks(arms: dict[str, str]) -> dict[str, Look]:
    """Choose a look for each arm (label -> agent): its variant's, else the agent's own, else one that is free."""
    found: dict[str, Look] = {}
    for arm, agent in arms.items():
        variants = [OTHERS[VARIANTS[word]] for word in arm.split()[1:] if word in VARIANTS]
        free = [look for look in [*variants, *([STYLES[agent]] if agent in STYLES and not variants else []), *OTHERS]
                if look not in found.values()]
        found[arm] = free[0] if free else OTHERS[len(found) % len(OTHERS)]
    return found


def curves(runs: Sequence[Run], title: str) -> Figure:
    """Draw visited cells (left) and their share (right) over steps, the number of cells as a dotted line."""
    figure = Figure((6.4, 3.8), layout="constrained")
    axes = figure.add_subplot()
    draw_curves(axes, runs, wrapped(title, 5.6))
    figure.legend(loc="outside lower center", ncols=columns_for(figure, axes.get_legend_handles_labels()[1]))
    return figure


def draw_curves(axes: Axes, runs: Sequence[Run], title: str) -> None:
    """Draw both scales into one panel; each agent is named once."""
    look = looks({run.agent: run.config["agent"]["name"] for run in runs})
    named: set[str] = set()
    for run in runs:
        colour, dashes, _ = look[run.agent]
        steps = np.unique(np.concatenate([run.curve.found, np.linspace(0, run.curve.steps, 400).astype(int)]))
        axes.plot(steps, run.curve.at(steps), color=colour, linestyle=dashes, linewidth=1.6,
                  label=None if run.agent in named else wrapped(run.agent, 5.0))
        named.add(run.agent)
    axes.set(title=title, xlabel="steps", ylabel=f"visited cells ({runs[0].rule})",
             xlim=(0, max(run.curve.steps for run in runs)))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    totals = [run.coverage.total for run in runs if run.coverage.total]
    if totals:
        draw_total(axes, max(totals), runs[0].denominator)


def share_of(run: Run, what: str = "") -> str:
    """The coverage of a run in words."""
    return covered(run.coverage.share, run.coverage.visited, run.coverage.total, what)


def draw_total(axes: Axes, total: int, denominator: str) -> None:
    """Draw the number of cells, and a scale of shares of it on the right."""
    axes.axhline(total, color=MAXIMUM, linestyle=":", linewidth=1.4)
    axes.annotate(f"{total:,} {denominator} cells", (0.01, total), xycoords=("axes fraction", "data"),
                  xytext=(0, 3), textcoords="offset points", color=MAXIMUM)
    axes.set(ylim=(0, total * ROOM))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
    scale = 100 / total
    share = axes.secondary_yaxis("right", functions=(partial(np.multiply, scale), partial(np.multiply, 1 / scale)))
    share.set_ylabel(f"share of {denominator} cells (%)")
