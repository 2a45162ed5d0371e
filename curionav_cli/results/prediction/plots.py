"""Figures of predicted observations (paper, section "Qualitative results"): real frames above predicted ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import patches
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from curionav_cli.constants import IMAGE_SIDE
from curionav_cli.results.lettering import wrapped
from curionav_cli.results.plots import OTHERS, STYLES
from curionav_cli.results.prediction.moved_objects import Ellipse
from curionav_cli.results.prediction.stored_predictions import Errors, Strip

ROWS = 3  # windows in a figure, at most two of one episode
SIDE, GAP, BREAK = IMAGE_SIDE, 4, 14  # pixels: a frame, between frames, between windows and after the last seen
COARSE = 6  # of 256 levels of a colour: invisible, and the file is half as large
INK, PALE, RED = "#111827", "#6b7280", "#dc2626"


def chosen(strips: Sequence[Strip]) -> list[Strip]:
    """Choose what is drawn: windows with circles first, then those of the newest episodes in which most changes."""
    def rank(strip: Strip) -> tuple[bool, int, float]:
        change = np.abs(np.diff(strip.truth[:, ::4, ::4].astype(np.int16), axis=0)).mean()
        return not any(strip.circles), -strip.episode, -float(change)
    taken: list[Strip] = []
    for strip in sorted(strips, key=rank):
        if len(taken) < ROWS and sum(other.episode == strip.episode for other in taken) < 2:
            taken.append(strip)
    return taken


def pictures(strips: Sequence[Strip], title: str, names: Sequence[str] = ()) -> Figure:
    """Draw real observations above predicted ones, a few steps apart; what an object's move changed is circled.

    names: the environment of each strip, where there are several; they are lettered then.
    """
    step = strips[0].step
    left = np.arange(len(step)) * (SIDE + GAP) + BREAK * (step > 0)
    top = np.arange(len(strips)) * (2 * SIDE + GAP + BREAK)
    wide, high = left[-1] + SIDE, top[-1] + 2 * SIDE + GAP
    canvas = np.full((high, wide, 3), 255, np.uint8)
    for strip, y in zip(strips, top.tolist()):
        for x, truth, predicted in zip(left, strip.truth, strip.predicted):
            canvas[y:y + SIDE, x:x + SIDE] = truth // COARSE * COARSE
            canvas[y + SIDE + GAP:y + 2 * SIDE + GAP, x:x + SIDE] = predicted // COARSE * COARSE
    figure, axes = a_canvas(canvas, title)
    label_steps(axes, step, left, strips[0].unit)
    where = [f"{chr(ord('a') + place)}  {name}\n" for place, name in enumerate(names)] or [""] * len(strips)
    for strip, y, name in zip(strips, top.tolist(), where):
        label_rows(axes, strip, y, name)
        for x, circles in zip(left.tolist(), strip.circles):
            for row in (y, y + SIDE + GAP):
                for circle in circles:
                    draw_circle(axes, circle, x, row)
    if any(any(strip.circles) for strip in strips):
        axes.annotate("red: differs because an object moved before the episode", (wide, high), (0, -5), ha="right",
                      va="top", textcoords="offset points", color=RED, fontsize=8)
    return figure


def draw_circle(axes: Axes, circle: Ellipse, x: int, y: int) -> None:
    """Draw a circle in the frame whose upper left corner is at x, y, and not beyond it."""
    drawn = axes.add_patch(patches.Ellipse((x + circle.x, y + circle.y), circle.width, circle.height, fill=False,
                                           edgecolor=RED, linewidth=1.6))
    drawn.set_clip_path(patches.Rectangle((x, y), SIDE, SIDE, transform=axes.transData))


def a_canvas(canvas: np.ndarray, title: str) -> tuple[Figure, Axes]:
    """Make a figure with two dots for each pixel, and a margin for the labels."""
    high, wide = canvas.shape[:2]
    figure = Figure(dpi=110)
    left, right, bottom = 130, 14, 30  # dots
    width = 2 * wide + left + right
    lines = wrapped(title, (width - left) / figure.dpi)
    top = 68 + 16 * (1 + lines.count("\n"))
    height = 2 * high + top + bottom
    figure.set_size_inches(width / figure.dpi, height / figure.dpi)
    axes = figure.add_axes((left / width, bottom / height, 2 * wide / width, 2 * high / height))
    axes.imshow(canvas, interpolation="nearest", extent=(0, wide, high, 0), aspect="auto")
    axes.set_axis_off()
    figure.text(left / width, 1 - 10 / height, lines, va="top", fontsize=10, color=INK)
    return figure, axes


def label_steps(axes: Axes, step: np.ndarray, left: np.ndarray, unit: str) -> None:
    """Write the number of the step (or `unit`) above each column, and whether it was seen or predicted."""
    for n, x in zip(step, left):
        text = f"{n}".replace("-", "−") if n <= 0 else f"+{n}"
        axes.annotate(text, (x + SIDE / 2, 0), (0, 3), textcoords="offset points", ha="center", color=INK)
    for name, columns in (("last seen", left[step <= 0]), (f"predicted: {unit} ahead", left[step > 0])):
        middle = (columns[0] + columns[-1] + SIDE) / 2
        axes.annotate(name, (middle, 0), (0, 16), textcoords="offset points", ha="center", color=PALE)


def label_rows(axes: Axes, strip: Strip, y: int, name: str) -> None:
    first = strip.frame[strip.step <= 0][-1]
    for row, at in (("real", y + SIDE / 2), ("model", y + SIDE * 1.5 + GAP)):
        axes.annotate(row, (0, at), (-5, 0), textcoords="offset points", ha="right", va="center", color=INK)
    axes.annotate(f"{name}episode {strip.episode}\nstep {first}", (0, y + SIDE + GAP / 2), (-40, 0), va="center",
                  ha="center", textcoords="offset points", rotation=90, color=PALE, fontsize=8)


def error_curve(errors: Errors, agent: str, over: str, title: str) -> Figure:
    """Draw the open-loop error against the steps ahead, beside repeating the last seen frame; mean and deviation."""
    figure = Figure((4.6, 3.2), layout="constrained")
    axes = figure.add_subplot()
    steps = errors.steps
    look = STYLES.get(agent.split()[0], OTHERS[0])  # a variant's name has its settings behind
    drawn = ((errors.repeated, "the last seen frame, repeated", {"color": PALE, "linestyle": "--"}),
             (errors.predicted, f"{agent}, open loop", {"color": look.color, "linestyle": look.dashes}))
    for error, name, style in drawn:
        mean, spread = error.mean(0), error.std(0, ddof=1) if len(error) > 1 else np.zeros(len(steps))
        axes.plot(steps, mean, label=name, linewidth=1.6, marker=".", markersize=4, **style)
        axes.fill_between(steps, mean - spread, mean + spread, color=style["color"], alpha=0.18, linewidth=0)
    axes.set(title=wrapped(title, 4.0), xlabel=f"{errors.unit} ahead", ylabel="mean squared error, [0, 1]",
             ylim=(0, None), xlim=(min(steps[0], steps[-1] - 0.5), steps[-1]))
    axes.set_xticks([steps[n - 1] for n in (1, 5, 10, 15, 20) if n <= len(steps)])
    axes.legend(title=f"mean ± sd over {over}", loc="best")
    return figure
