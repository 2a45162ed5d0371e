"""The figure of probes: open-loop error and surprise of world models over steps or updates."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from curionav_cli.results.comparison.plots import GREY, draw_line
from curionav_cli.results.lettering import columns_for, wrapped
from curionav_cli.results.plots import Look
from curionav_cli.results.probing.curves import ProbeCurve, ProbeField
from curionav_cli.results.statistics import mean_interval

PANELS = {"error": ("a  open-loop error", "mean squared error, [0, 1]"), "surprise": ("b  surprise", "KL, nats")}

REPEATED = "the last seen frame, repeated"


def figure(field: ProbeField, look: dict[str, Look]) -> Figure:
    """Draw error and surprise of every arm: mean, 95 % t interval, and every run as a thin line."""
    used = {arm: look[arm] for arm in field.arms}
    drawn = Figure((7.2, 3.4), layout="constrained")
    for axes, (measure, (title, label)) in zip(drawn.subplots(1, 2), PANELS.items()):
        for arm in used:
            draw_arm(axes, field, arm, measure, used)
        axes.set_title(title, loc="left")
        axes.set(xlabel=field.axis, ylabel=label)
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    left, _ = drawn.axes
    repeated = [curve.value("repeat", field.at) for curves in field.arms.values() for curve in curves]
    left.axhline(float(np.mean(repeated)), color=GREY, linestyle="--", linewidth=1.0, label=REPEATED)
    names = left.get_legend_handles_labels()
    drawn.legend(*names, loc="outside lower center", ncols=columns_for(drawn, names[1], 4))
    drawn.suptitle(wrapped(f"{field.env}: world models on the building's fixed probe", 6.8), fontsize=9)
    return drawn


def draw_arm(axes: Axes, field: ProbeField, arm: str, measure: str, look: dict[str, Look]) -> None:
    """Draw a measure of one arm up to the end that all runs have."""
    curves = field.arms[arm]
    at = moments(curves, field.at)
    values = np.array([np.interp(at, curve.at, curve.values[measure]) for curve in curves])
    if len(curves) > 1:
        axes.plot(at, values.T, color=look[arm].color, linewidth=0.4, alpha=0.5)
    draw_line(axes, at, mean_interval(values), arm, look)


def moments(curves: list[ProbeCurve], until: int) -> np.ndarray:
    """Where any of these curves was measured, from where all of them were, up to `until`."""
    at = np.unique(np.concatenate([curve.at for curve in curves]))
    return at[(at >= max(curve.at[0] for curve in curves)) & (at <= until)]
