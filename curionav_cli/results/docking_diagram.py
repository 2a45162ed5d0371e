"""The paper's docking diagram: client, server, its phases and recoveries, and how often returns to dock went each way.

Boxes are the phases of the docking server, arrows the changes of phase in its feedback, with their counts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from curionav_cli.results.lettering import wrapped

PLACES: Mapping[str, tuple[float, float]] = {  # of each phase, in boxes to the right and up
    "idle": (0, 1), "nav_to_staging": (1, 1), "acquire": (2, 1), "approach": (3, 1), "contact": (4, 1),
    "wait_for_charge": (5, 1), "docked": (6, 1), "recover": (2.5, 0), "human_intervention": (5, 0),
}
WIDE, HIGH = 1.75, 1.5  # inches from box to box
FILLS = {"docked": "#dcfce7", "human_intervention": "#fee2e2", "recover": "#fef3c7"}
INK, PALE = "#111827", "#4b5563"
Moves = Counter[tuple[str, str]]  # phases, by name


def diagram(moves: Moves, recoveries: Sequence[str], final: Sequence[str], title: str) -> Figure:
    """Draw the phases and how often one followed another.

    recoveries: their names, in the order in which they are tried; final: codes after which none is tried.
    """
    figure = Figure((7 * WIDE + 0.3, 3.4 * HIGH), layout="constrained")
    axes = figure.add_subplot()
    boxes = {phase: box(axes, x, y, phase.replace("_", "\n", 1), FILLS.get(phase, "#e0f2fe"))
             for phase, (x, y) in PLACES.items()}
    client = box(axes, 0, 2, "docking client", "#ffffff")
    arrow(axes, client, boxes["idle"], "goal: dock, navigate", 0.0)
    arrow(axes, boxes["docked"], client, "result: docked", 0.2)
    for (before, after), count in sorted(moves.items(), key=lambda item: item[0][0] + item[0][1]):
        (x, y), (right, up) = PLACES[before], PLACES[after]
        bend = 0.25 if y != up else 0.0 if right - x == 1 or y == 0 else 0.45
        arrow(axes, boxes[before], boxes[after], f"{count:,}", bend)
    axes.text(2.5, -0.42, "in this order: " + ", ".join(recoveries), ha="center", va="top", fontsize=7, color=PALE,
              wrap=True)
    axes.text(5, -0.42, f"after the last recovery, or at once:\n{', '.join(final)}", ha="center", va="top", fontsize=7,
              color=PALE, wrap=True)
    axes.set(xlim=(-0.6, 6.6), ylim=(-0.8, 2.4), title=wrapped(title, 7 * WIDE))
    axes.set_axis_off()
    return figure


def box(axes: Axes, x: float, y: float, name: str, fill: str) -> FancyBboxPatch:
    made = FancyBboxPatch((x - 0.3, y - 0.2), 0.6, 0.4, boxstyle="round,pad=0.04", facecolor=fill, edgecolor=INK,
                          linewidth=0.9, zorder=3)
    axes.text(x, y, name, ha="center", va="center", fontsize=8, color=INK, zorder=4)
    axes.add_patch(made)
    return made


def arrow(axes: Axes, begin: FancyBboxPatch, end: FancyBboxPatch, name: str, bend: float) -> None:
    """From box to box with a word in the middle."""
    (x, y), (right, up) = (middle(one) for one in (begin, end))
    axes.annotate("", (right, up), (x, y), zorder=1, arrowprops={
        "arrowstyle": "-|>", "color": INK, "linewidth": 0.9, "patchA": begin, "patchB": end, "shrinkA": 2, "shrinkB": 2,
        "connectionstyle": f"arc3,rad={bend}"})
    away = bend / 2 * HIGH / WIDE  # of the length, to the right of the way: where the arc is
    axes.text((x + right) / 2 + away * (up - y), (y + up) / 2 - bend / 2 * WIDE / HIGH * (right - x), name, fontsize=7,
              ha="center", va="center", color=INK, zorder=2, bbox={"facecolor": "white", "edgecolor": "none", "pad": 1})


def middle(one: FancyBboxPatch) -> tuple[float, float]:
    return one.get_x() + one.get_width() / 2, one.get_y() + one.get_height() / 2
