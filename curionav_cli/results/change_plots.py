"""The figure of what a changing world does: who is near what moved, and how surprise there falls with its age."""

from __future__ import annotations

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

STRETCHES = 20  # of the longest run; those of the others are as long
LEAST = 10  # episodes for which surprise at an age is drawn
GREY = "#6b7280"


def figure(runs: Sequence[Seen], env: str) -> Figure:
    """Draw coverage, the share of steps near what just moved, and relative surprise by age; a line for each run."""
    drawn = Figure((9.6, 3.6), layout="constrained")
    left, middle, right = drawn.subplots(1, 3)
    names, named = arms(runs), set[str]()
    chosen, longest = looks(runs, names), max(len(one.age) for one in runs)
    for one, name in zip(runs, names):
        curve, look = one.run.curve, chosen[name]
        left.plot([0, *curve.found, curve.steps], [0, *(100 * curve.at(curve.found) / curve.cells),
                                                   100 * len(curve.found) / curve.cells], **styled(look),
                  label=None if name in named else name)
        named.add(name)
        middle.plot(*near(one, max(1, round(STRETCHES * len(one.age) / longest))), **styled(look))
        by_age(right, one, look)
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


def near(one: Seen, stretches: int) -> tuple[np.ndarray, np.ndarray]:
    """Steps, and the share of steps near what just moved, %."""
    steps, share = changes.shares(one, stretches)
    return steps, 100 * share


def by_age(axes: Axes, one: Seen, look: Look) -> None:
    """Draw relative surprise by age, with its interval, where there are LEAST episodes."""
    rows = [row for row in changes.age_rows(one) if row["relative"] is not None and row["number"] != changes.ELSEWHERE
            and row["episodes"] >= LEAST]
    if rows:
        values = [row["relative"] for row in rows]
        bars = [[each.value - each.low for each in values], [each.high - each.value for each in values]]
        axes.errorbar([row["number"] for row in rows], [each.value for each in values], yerr=bars, capsize=2,
                      marker=look.marker, markersize=4, **styled(look))
