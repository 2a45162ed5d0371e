"""Figures of a comparison, from numbers estimated elsewhere: one for each environment, one over all runs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, MaxNLocator

from curionav_cli.results.comparison.comparison import Comparison, Field
from curionav_cli.results.comparison.estimates import ALL
from curionav_cli.results.lettering import columns_for, legible, wrapped
from curionav_cli.results.plots import MAXIMUM, Look
from curionav_cli.results.statistics import Estimate, mean_interval, mean_of_means
from curionav_cli.results.tables import Row

POINTS = 200  # of a drawn curve
MARKS = 8  # on it
GREY = "#6b7280"


def environment(field: Field, look: dict[str, Look], pairs: Sequence[Row], base: str, meaning: str) -> Figure:
    """Draw coverage over steps, the area under it, and its paired differences to `base`.

    meaning: what counts as covered, in words.
    """
    used = {arm: look[arm] for arm in field.arms}
    cells = next(iter(field.arms.values()))[0].curve.cells
    figure, (left, middle, right) = panels(
        f"{field.env}, {cells:,} {meaning}: mean, 95 % t interval, and every seed", used)
    draw_curves(left, field, used)
    scores = {arm: field.scores(arm) for arm in used}
    draw_rows(middle, used, {arm: mean_interval(areas) for arm, areas in scores.items()}, scores)
    name(middle, "b  area under the curve", "mean share of the cells")
    beside = against(pairs, base, field.env)
    right.set_visible(bool(beside))
    draw_rows(right, used, {other: row["difference"] for other, row in beside.items()},
              {other: field.difference(row["arm"], row["minus"]) for other, row in beside.items()})
    write_beside(right, used, {other: f"n = {row['n']}\np = {row['p']:.2g}" for other, row in beside.items()})
    right.axvline(0, color=GREY, linewidth=0.8, zorder=0)
    name(right, f"c  {direction(beside, base, 'minus')}", "difference, same seeds")
    return figure


def over_all(comparison: Comparison, look: dict[str, Look], pairs: Sequence[Row], base: str, rows: Sequence[Row],
             profiles: dict[str, Estimate], thresholds: np.ndarray) -> Figure:
    """Draw performance profiles at `thresholds` (K,), interquartile means, probabilities of improvement over `base`."""
    envs = ", ".join(field.env for field in comparison.common)
    figure, (left, middle, right) = panels(
        f"{envs}: {sum(row['n'] for row in rows)} runs, 95 % interval of a stratified bootstrap", look)
    for arm in look:
        draw_line(left, thresholds, profiles[arm], arm, look)
    left.set(ylabel="share of the runs above it", ylim=(0, 1.02), xlim=(thresholds[0], thresholds[-1]))
    name(left, "a  performance profile", "area under the curve")
    draw_rows(middle, look, {row["arm"]: row["interquartile_mean"] for row in rows},
              {arm: np.concatenate([field.scores(arm) for field in comparison.common]) for arm in look})
    name(middle, "b  interquartile mean", "area under the curve")
    beside = against(pairs, base, ALL)
    draw_rows(right, look, {other: row["improvement"] for other, row in beside.items()}, {})
    right.set_xlim(-0.04, 1.04)
    right.axvline(0.5, color=GREY, linewidth=0.8, zorder=0)
    name(right, f"c  {direction(beside, base, 'over')}", "probability of improvement")
    return figure


def courses(comparison: Comparison, look: dict[str, Look], meaning: str) -> Figure:
    """Draw the paper's figure of the apartments: visited cells in each environment, their maximum dotted.

    The last panel is the mean share over the environments that every arm has runs in, up to the end of the shortest.
    """
    drawn = len(comparison.fields) + bool(comparison.common[1:])
    across = min(drawn, 4)
    figure = Figure((0.6 + 3.3 * across, 0.5 + 3.0 * -(-drawn // across)), layout="constrained")
    all_axes = list(figure.subplots(-(-drawn // across), across, squeeze=False).flat)
    letters = [chr(ord("a") + place) for place in range(drawn)]
    for letter, axes, field in zip(letters, all_axes, comparison.fields):
        draw_cells(axes, field, {arm: look[arm] for arm in field.arms})
        axes.set_title(wrapped(f"{letter}  {field.env}", 2.6), loc="left")
    if comparison.common[1:]:
        draw_mean(all_axes[drawn - 1], comparison.common, look)
        all_axes[drawn - 1].set_title(f"{letters[-1]}  over all runs", loc="left")
    for axes in all_axes[drawn:]:
        axes.set_axis_off()
    handles = {label: line for axes in all_axes for line, label in zip(*axes.get_legend_handles_labels())}
    figure.legend(list(handles.values()), list(handles), loc="outside lower center",
                  ncols=columns_for(figure, list(handles), 4))
    figure.suptitle(wrapped(f"{meaning}: mean, 95 % t interval, and every seed", 3.3 * across), fontsize=9)
    return figure


def draw_cells(axes: Axes, field: Field, look: dict[str, Look]) -> None:
    """Visited cells on the left, their share on the right, and how many there are as a dotted line."""
    steps, cells = moments(field.horizon), next(iter(field.arms.values()))[0].curve.cells
    for arm in look:
        visited = cells * field.shares(arm, steps)
        axes.plot(steps, visited.T, color=look[arm].color, linewidth=0.4, alpha=0.5)
        draw_line(axes, steps, mean_interval(visited), arm, look)
    axes.axhline(cells, color=MAXIMUM, linestyle=":", linewidth=1.4)
    axes.set(xlabel="steps", ylabel=f"visited of {cells:,} cells", xlim=(0, field.horizon), ylim=(0, 1.04 * cells))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    axes.yaxis.set_major_formatter(EngFormatter(sep=""))
    share = axes.secondary_yaxis("right", functions=(partial(np.multiply, 100 / cells),
                                                     partial(np.multiply, cells / 100)))
    share.set_ylabel("share (%)")


def draw_mean(axes: Axes, fields: Sequence[Field], look: dict[str, Look]) -> None:
    """The mean over environments of the mean over seeds, as a share."""
    horizon = min(field.horizon for field in fields)
    steps = moments(horizon)
    for arm in look:
        shares = [100 * field.shares(arm, steps) for field in fields]
        each = [mean_of_means([one[:, step] for one in shares]) for step in range(len(steps))]
        draw_line(axes, steps, Estimate(*np.array(each).T), arm, look)
    axes.axhline(100, color=MAXIMUM, linestyle=":", linewidth=1.4)
    axes.set(xlabel="steps", ylabel="mean share of the cells (%)", xlim=(0, horizon), ylim=(0, 104))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))


def moments(horizon: int) -> np.ndarray:
    """The steps at which a curve is drawn."""
    return np.unique(np.linspace(0, horizon, POINTS + 1).astype(int))


def panels(title: str, look: dict[str, Look]) -> tuple[Figure, list[Axes]]:
    """Three axes: a square one, and two with a row for each arm, named once; the arms' names below."""
    names = [legible(wrapped(arm.replace(" ", "\n"), 2.0)) for arm in look]
    row = max(0.36, 0.18 * max(one.count("\n") + 1 for one in names))  # inches: no name runs into the next
    figure = Figure((8.6, max(2.9, 1.5 + row * len(look))), layout="constrained")
    left, middle, right = figure.subplots(1, 3, width_ratios=(1.35, 1, 0.9))
    right.sharey(middle)
    middle.set_yticks(range(len(look)), names)
    middle.set_ylim(len(look) - 0.4, -0.6)
    for label, (color, _, _) in zip(middle.get_yticklabels(), look.values()):
        label.set_color(color)
    right.tick_params(axis="y", labelleft=False)
    for axes in (middle, right):
        axes.grid(axis="x", color="#e5e7eb", linewidth=0.6)
        axes.xaxis.set_major_locator(MaxNLocator(3))
    figure.suptitle(wrapped(title, 8.2), fontsize=9)
    return figure, [left, middle, right]


def draw_curves(axes: Axes, field: Field, look: dict[str, Look]) -> None:
    """The mean of every arm over its seeds with a pointwise interval, and every seed as a thin line."""
    steps = moments(field.horizon)
    for arm in look:
        shares = 100 * field.shares(arm, steps)
        axes.plot(steps, shares.T, color=look[arm].color, linewidth=0.4, alpha=0.5)
        draw_line(axes, steps, mean_interval(shares), arm, look)
    axes.set(ylabel="share of the cells (%)", xlim=(0, field.horizon))
    name(axes, "a  coverage", "steps")
    axes.set_ylim(0, min(102, axes.get_ylim()[1]))
    axes.xaxis.set_major_formatter(EngFormatter(sep=""))


def draw_line(axes: Axes, x: np.ndarray, line: Estimate, arm: str, look: dict[str, Look]) -> None:
    """A line with its band; markers of different arms stand apart."""
    color, dashes, marker = look[arm]
    gap = max(1, len(x) // MARKS)
    offset = gap * list(look).index(arm) // len(look)
    axes.fill_between(x, line.low, line.high, color=color, alpha=0.13, linewidth=0)
    axes.plot(x, line.value, color=color, linestyle=dashes, marker=marker, markersize=3.5, markevery=(offset, gap),
              linewidth=1.5, label=wrapped(arm, 6.0))


def draw_rows(axes: Axes, look: dict[str, Look], estimates: dict[str, Estimate], runs: dict[str, np.ndarray]) -> None:
    """For each arm its estimate and interval, and every run as a dot below."""
    for row, (arm, (color, _, marker)) in enumerate(look.items()):
        if arm in estimates:
            value, low, high = map(float, estimates[arm])
            axes.plot([low, high], [row, row], color=color, linewidth=1.5)
            axes.plot([value], [row], color=color, marker=marker, markersize=5.5)
            dots = runs.get(arm, np.array([]))
            axes.plot(dots, np.full(len(dots), row + 0.25), ".", color=color, markersize=3, alpha=0.7)


def write_beside(axes: Axes, look: dict[str, Look], words: dict[str, str]) -> None:
    """A few words right of each arm's row."""
    for row, arm in enumerate(look):
        axes.text(1.02, row, words.get(arm, ""), transform=axes.get_yaxis_transform(), va="center", fontsize=7)


def name(axes: Axes, title: str, label: str) -> None:
    axes.set_title(wrapped(title, 2.2, "    "), loc="left")
    axes.set_xlabel(label)


def against(pairs: Sequence[Row], base: str, env: str) -> dict[str, Row]:
    """The pairs of this environment that `base` is in, by the other arm."""
    here = [row for row in pairs if row["env"] == env and base in (row["arm"], row["minus"])]
    return {row["arm"] if row["minus"] == base else row["minus"]: row for row in here}


def direction(beside: dict[str, Row], base: str, word: str) -> str:
    """'random minus the others', or 'minus random' where all others are compared with it."""
    return f"{base} {word} the others" if any(row["arm"] == base for row in beside.values()) else f"{word} {base}"
