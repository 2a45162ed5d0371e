"""The figure of what a changing world does: who is near what moved, and how surprise there falls with its age."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, MaxNLocator

from curionav_cli.results import changes
from curionav_cli.results.changes import Seen
from curionav_cli.results.lettering import columns_for, legible, wrapped
from curionav_cli.results.plots import OTHERS, STYLES, Look
from curionav_cli.results.statistics import mean_interval

STRETCHES = 20  # of the longest run at most; those of the others are as long
LEAST = 10  # episodes for which surprise at an age is drawn
GREY = "#6b7280"


def figure(runs: Sequence[Seen], env: str) -> Figure:
    """Draw coverage, a line for each run, and of the runs that differ in their seed only together the share of steps
    near what just moved, and relative surprise by age."""
    drawn = Figure((9.6, 3.6), layout="constrained")
    left, middle, right = drawn.subplots(1, 3)
    names = arms(runs)
    chosen, width = looks(runs, names), math.ceil(max(len(one.age) for one in runs) / STRETCHES)
    for name, look in chosen.items():
        arm = [one for one, other in zip(runs, names) if other == name]
        for one in arm:
            curve = one.run.curve
            left.plot([0, *curve.found, curve.steps], [0, *(100 * curve.at(curve.found) / curve.cells),
                                                       100 * len(curve.found) / curve.cells], **styled(look),
                      label=name if one is arm[0] else None)
        middle.plot(*near(arm, width), **styled(look))
        by_age(right, arm, look)
    right.axhline(1.0, color=GREY, linestyle=":", linewidth=1.0)
    for axes, title, x, y in ((left, "a  coverage", "steps", "share of the floor's cells (%)"),
                              (middle, f"b  within {changes.NEAR:g} m of what just moved", "steps",
                               "share of steps (%)"),
                              (right, "c  surprise there", "episodes since the move", "KL over KL elsewhere")):
        axes.set_title(title, loc="left")
        axes.set(xlabel=x, ylabel=y, ylim=(0, None))
    right.set_xlim(-0.5, max([1, *(age for one in runs for here in one.kl.values() for age in here)]) + 0.5)
    right.xaxis.set_major_locator(MaxNLocator(integer=True))
    for axes in (left, middle):
        axes.xaxis.set_major_formatter(EngFormatter(sep=""))
    names = left.get_legend_handles_labels()
    drawn.legend(*names, loc="outside lower center", ncols=columns_for(drawn, names[1], 4))
    control = "" if all(one.changing for one in runs) else ": without changes, the same places in the same episodes"
    drawn.suptitle(wrapped(f"{env}{control}", 9.0), fontsize=9)
    return drawn


def arms(runs: Sequence[Seen]) -> list[str]:
    """A name for each run, the same for runs that differ in their seed only."""
    named = [(one.run.agent, "with" if one.changing else "without") for one in runs]
    seeds = {name: sorted({str(one.run.seed) for one, other in zip(runs, named) if other == name}) for name in named}
    return [legible(f"{agent} {how} changes, seed{'s' * (len(seeds[agent, how]) > 1)} {', '.join(seeds[agent, how])}")
            for agent, how in named]


def looks(runs: Sequence[Seen], names: Sequence[str]) -> dict[str, Look]:
    """A look for each name of a run."""
    found: dict[str, Look] = {}
    for name, one in sorted(zip(names, runs), key=lambda pair: not pair[1].changing):  # the agent's own: with changes
        free = [look for look in (STYLES.get(one.run.config["agent"]["name"], OTHERS[0]), *OTHERS)
                if look not in found.values()]
        found.setdefault(name, (free or list(OTHERS))[0])
    return found


def styled(look: Look) -> dict[str, Any]:
    return {"color": look.color, "linestyle": look.dashes, "linewidth": 1.4}


def near(arm: Sequence[Seen], width: int) -> tuple[np.ndarray, np.ndarray]:
    """Steps, and the share of steps near what just moved, %."""
    steps, share = changes.shares(arm, width)
    return steps, 100 * share


def by_age(axes: Axes, arm: Sequence[Seen], look: Look) -> None:
    """Draw relative surprise by age, with its interval, where there are LEAST episodes of all its runs."""
    ratios = changes.relative(here for one in arm for here in one.kl.values())
    ages = [age for age in sorted(ratios) if age != changes.ELSEWHERE and len(ratios[age]) >= LEAST]
    if ages:
        value, low, high = np.array([mean_interval(np.array(ratios[age])) for age in ages]).T
        axes.errorbar(ages, value, yerr=[value - low, high - value], capsize=2, marker=look.marker, markersize=4,
                      **styled(look))
