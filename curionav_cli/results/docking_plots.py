"""True poses around the dock where the approach began, coloured by how the return to dock ended."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle, Wedge

from curionav_cli.records import DockReport
from curionav_cli.results.lettering import wrapped

COLOURS = (  # one for every way in which a return to dock can end
    "#0b5fa5", "#15803d", "#c2410c", "#be185d", "#6d28d9", "#92400e", "#111827", "#0891b2", "#65a30d", "#ca8a04",
    "#f472b6", "#a78bfa", "#9ca3af", "#7f1d1d", "#064e3b", "#1e3a8a", "#e11d48", "#14b8a6", "#f59e0b", "#475569")
FIRST, LATER = "docked at once", "docked after a recovery"
ARROW = 0.12  # metres


def arrivals(docks: Sequence[DockReport], cone: float, reach: float, radius: float, title: str) -> Figure:
    """Draw true poses at arrival in the dock's frame, metres (left), and outcomes by the estimate's error (right).

    cone: degrees to either side that the light reaches, reach: metres, radius: of the robot.
    """
    figure = Figure((9.6, 4.6), layout="constrained")
    around, beside = figure.subplots(1, 2, width_ratios=(1.25, 1))
    arrived = [dock for dock in docks if dock.arrival]
    kinds = [kind(dock) for dock in arrived]
    names = sorted(set(kinds), key=lambda name: (name not in (FIRST, LATER), -kinds.count(name)))
    pose = np.array([dock.arrival for dock in arrived]).reshape(-1, 3)
    around.add_patch(Wedge((-radius, 0.0), reach, -cone, cone, facecolor="#fef3c7", edgecolor="#d97706", linewidth=0.6))
    around.add_patch(Rectangle((-radius - 0.1, -0.12), 0.1, 0.24, facecolor="#4b5563"))
    around.add_patch(Circle((0.0, 0.0), radius, fill=False, linestyle=":", edgecolor="#4b5563"))
    for name, colour in zip(names, COLOURS):
        chosen = np.array([found == name for found in kinds])
        x, y, yaw = pose[chosen].T
        around.plot(x, y, ".", color=colour, markersize=3, label=f"{name} ({chosen.sum()})")
        around.plot([x, x - ARROW * np.cos(yaw)], [y, y - ARROW * np.sin(yaw)], color=colour, linewidth=0.4)
    around.set(title=wrapped(title, 5.0), xlabel="before the dock (m)", ylabel="to the dock's left (m)", aspect="equal")
    if names:
        around.legend(fontsize=7, loc="upper left")
    draw_errors(beside, arrived, kinds, names)
    return figure


def draw_errors(axes, arrived: Sequence[DockReport], kinds: Sequence[str], names: Sequence[str]) -> None:
    """Draw stacked counts over the error of the estimated position, metres."""
    error = np.array([np.hypot(*dock.error[:2]) for dock in arrived if dock.error])
    bins = np.linspace(0.0, max(0.2, float(error.max(initial=0.0))), 25)
    parts = [error[[found == name for found in kinds]] for name in names]
    if parts:
        axes.hist(parts, bins, stacked=True, color=COLOURS[:len(parts)])
    axes.set(xlabel="error of the estimated position at arrival (m)", ylabel="returns to dock")


def kind(dock: DockReport) -> str:
    """Name of the series that an arrival is drawn in."""
    if not dock.success:
        return dock.code
    return LATER if dock.recoveries else FIRST
