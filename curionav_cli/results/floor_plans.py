"""A floor plan as a map: walls, glass, unknown space, what can be reached, start and dock, in the axes of the map.

Axes are metres in the frame that the plan's origin is given in, turned by its yaw as RViz shows it. Everything is
drawn in metres of the scene, by the transform `frame`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb, to_rgba
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Patch
from matplotlib.transforms import Affine2D
from mpl_toolkits.axes_grid1.anchored_artists import AnchoredSizeBar

from curionav_cli.records import ORIGIN, FloorPlan, Pose
from curionav_cli.results.lettering import LINE, columns_for, wrapped


class Kind(NamedTuple):
    """What a cell can be, and how that is drawn."""

    color: str
    name: str


KINDS = (  # of several cells in one drawn square the last of these is shown: no wall gets lost
    Kind("#ffffff", ""),
    Kind("#b4c2d3", "unknown"),
    Kind("#dfe0e2", "floor, out of reach"),
    Kind("#f7f7f5", "can be reached"),
    Kind("#6fd3e5", "occupancy 1 to 99, free"),
    Kind("#0891b2", "occupancy 1 to 99, an obstacle"),
    Kind("#374151", "wall or furniture"),
)
NOTHING, UNKNOWN, FLOOR, REACHED, PART, PART_SOLID, SOLID = range(len(KINDS))
START, DOCK = ("s", "#1d4ed8"), ("^", "#15803d")  # marker and colour
SQUARES = 330  # drawn along the longer side of a panel, about as many as it has dots
MARGIN = 0.03  # of the longer side, around the building
STRIP = 0.07  # of the longer side: the room below it for the scale bar
PALE = 0.45  # opacity of what can be reached, over the picture of a scan
LONGEST, DOTS = 9.0, 200  # inches of a figure of the plan alone, and dots in one


def kinds(plan: FloorPlan) -> np.ndarray:
    """(rows, columns) int: for each cell its index in KINDS."""
    found = np.where(plan.unknown, UNKNOWN, NOTHING)
    occupied = np.zeros(plan.solid.shape) if plan.occupancy is None else plan.occupancy
    if plan.occupancy is not None:
        found[occupied == 0] = FLOOR
    found[plan.floor], found[plan.visitable] = FLOOR, REACHED
    part = (occupied > 0) & (occupied < 100)
    found[part], found[plan.solid] = PART, SOLID
    found[part & plan.solid] = PART_SOLID
    return found


def window(plan: FloorPlan) -> tuple[slice, slice]:
    """Rows and columns around the building, without the empty border of a map."""
    used = np.argwhere(plan.floor)
    margin = max(2, round(MARGIN * (np.ptp(used, axis=0).max() + 1)))
    low, high = np.maximum(used.min(0) - margin, 0), used.max(0) + 1 + margin
    return slice(low[0], min(high[0], len(plan.floor))), slice(low[1], min(high[1], plan.floor.shape[1]))


def frame(plan: FloorPlan) -> Affine2D:
    """Transform from metres of the scene to those of its map."""
    return Affine2D().rotate(plan.map_origin.yaw).translate(plan.map_origin.x, plan.map_origin.y)


def bounds(plan: FloorPlan) -> tuple[float, float, float, float]:
    """Least and greatest x, least and greatest y of the window, in metres of the map."""
    rows, columns = window(plan)
    corners = [(x * plan.cell, y * plan.cell) for x in (columns.start, columns.stop) for y in (rows.start, rows.stop)]
    x, y = frame(plan).transform(corners).T
    return x.min(), x.max(), y.min(), y.max()


def size_of(plan: FloorPlan) -> tuple[float, float]:
    """Width and height of the window in metres."""
    x0, x1, y0, y1 = bounds(plan)
    return x1 - x0, y1 - y0


def squares(grid: np.ndarray, side: int) -> np.ndarray:
    """The highest value in every square of side x side cells."""
    rows, columns = grid.shape
    whole = np.pad(grid, ((0, -rows % side), (0, -columns % side)))
    return whole.reshape(whole.shape[0] // side, side, -1, side).max((1, 3))


def draw_plan(axes: Axes, plan: FloorPlan, most: int = SQUARES, walls_only: bool = False) -> None:
    """Draw the plan, cropped to the building. most: squares along its longer side; walls_only: only obstacles."""
    if plan.picture is not None:
        draw_picture(axes, plan, walls_only)
        return
    rows, columns = window(plan)
    side = max(1, -(-max(rows.stop - rows.start, columns.stop - columns.start) // most))
    grid = squares(kinds(plan)[rows, columns], side)
    colours = np.array([to_rgba(kind.color, not walls_only or number >= PART) for number, kind in enumerate(KINDS)])
    low = columns.start * plan.cell, rows.start * plan.cell
    draw_grid(axes, plan, colours[grid], side, low, zorder=2 if walls_only else 0)
    frame_axes(axes, plan)


def draw_picture(axes: Axes, plan: FloorPlan, walls_only: bool) -> None:
    """Draw a scan from above, and pale what can be reached of it; its walls are in the picture."""
    if plan.picture is not None and not walls_only:
        height, width = (side * plan.cell for side in plan.visitable.shape)
        axes.imshow(plan.picture, origin="lower", extent=(0, width, 0, height), interpolation="antialiased",
                    transform=frame(plan) + axes.transData, zorder=0)
        pale = np.where(plan.visitable[..., None], to_rgba(KINDS[REACHED].color, PALE), 0.0)
        draw_grid(axes, plan, pale, 1, zorder=0.5)
    frame_axes(axes, plan)


def frame_axes(axes: Axes, plan: FloorPlan) -> None:
    """Crop the axes to the building, in metres of its map."""
    x0, x1, y0, y1 = bounds(plan)
    axes.set(xlim=(x0, x1), ylim=(y0, y1), xlabel="x (m)", ylabel="y (m)", aspect="equal")
    axes.locator_params(steps=(1, 2, 5, 10), min_n_ticks=1)


def draw_grid(axes: Axes, plan: FloorPlan, grid: np.ndarray, side: int, low: tuple[float, float] = (0.0, 0.0),
              **style: Any) -> AxesImage:
    """Draw squares of side x side cells as an image, the lower left corner at `low` in metres of the scene."""
    step = side * plan.cell
    extent = (low[0], low[0] + grid.shape[1] * step, low[1], low[1] + grid.shape[0] * step)
    return axes.imshow(grid, origin="lower", extent=extent, interpolation="nearest",
                       transform=frame(plan) + axes.transData, **style)


def picture_of(plan: FloorPlan) -> np.ndarray:
    """(rows, columns, 3): a colour for each cell."""
    return np.array([to_rgb(kind.color) for kind in KINDS])[kinds(plan)]


def mark_places(axes: Axes, plan: FloorPlan, size: float = 7.0) -> None:
    """Mark the start by a blue square and a dock elsewhere by a green triangle; a line shows the yaw."""
    alone = plan.dock is None or plan.dock == plan.start
    mark(axes, plan, plan.start, START, "start and dock" if alone else "start", size)
    if plan.dock and not alone:
        mark(axes, plan, plan.dock, DOCK, "dock", size + 1)


def mark(axes: Axes, plan: FloorPlan, pose: Pose, look: tuple[str, str], name: str, size: float) -> None:
    x, y = frame(plan).transform((pose.x, pose.y))
    yaw, (marker, color) = pose.yaw + plan.map_origin.yaw, look
    line = {"arrowstyle": "-", "color": color, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (x, y), (1.4 * size * np.cos(yaw), 1.4 * size * np.sin(yaw)), textcoords="offset points",
                  zorder=4, arrowprops=line)
    axes.plot(x, y, marker, color=color, markersize=size, markeredgecolor="white", markeredgewidth=0.8, zorder=5,
              label=name, linestyle="none")


def add_scale_bar(axes: Axes, plan: FloorPlan) -> None:
    """Add a scale bar of 1, 2 or 5 times a power of ten metres in a strip below the building."""
    wide, high = size_of(plan)
    fits = min(0.8 * wide, max(wide / 4, 0.05 * high))
    power = 10.0 ** np.floor(np.log10(fits))
    length = power * max(step for step in (1, 2, 5) if step * power <= fits)
    where = "lower right" if 5 * wide > high else "lower center"
    low, top = axes.get_ylim()
    axes.set_ylim(low - STRIP * max(wide, high), top)
    axes.add_artist(AnchoredSizeBar(axes.transData, length, f"{length:g} m", where, pad=0.2, borderpad=0.2,
                                    sep=2, frameon=False, size_vertical=0.006 * max(wide, high), color="#111827"))


def meanings(axes: Axes, plan: FloorPlan) -> list[Artist]:
    """Handles of a legend: the places that are marked, and the kinds of cells that the window shows."""
    places: list[Artist] = [line for line in axes.get_lines() if str(line.get_label())[0] != "_"]
    shown = np.unique(kinds(plan)[window(plan)]) if plan.picture is None else np.array([REACHED])
    shown = shown if plan.bounded else shown[shown != REACHED]  # of a real floor without a map nobody knows
    return [*places, *(Patch(facecolor=KINDS[number].color, edgecolor="#6b7280", linewidth=0.5,
                             label=KINDS[number].name) for number in shown[::-1] if KINDS[number].name)]


def add_legend(figure: Figure, handles: Sequence[Artist]) -> None:
    """Add a legend below the figure, in as many columns as fit."""
    names = [str(handle.get_label()) for handle in handles]
    figure.legend(handles=list(handles), loc="outside lower center", ncols=columns_for(figure, names))


def figure_size(plan: FloorPlan, longest: float, least: float) -> tuple[float, float]:
    """Inches of the building alone: its longer side, half as much again of a corridor; `least` for the title above."""
    wide, high = size_of(plan)
    longest *= float(np.clip(max(wide / high, high / wide) / 5, 1.0, 1.5))
    return max(least, longest * min(1.0, wide / high)), max(0.3, longest * min(1.0, high / wide))


def located(pose: Pose) -> str:
    turned = f", turned by {np.degrees(pose.yaw):.3g} degrees" if pose.yaw else ""
    return f"x = {pose.x:.6g}, y = {pose.y:.6g} m{turned}"


def sheet(plan: FloorPlan, title: str) -> Figure:
    """Draw the plan of a world with grid, scale bar, start and dock."""
    if plan.picture is not None:
        title += "\nThe axes are those of the scan; env.start and env.dock count in them"
    elif plan.map_origin != ORIGIN:
        title += (f"\nIts lower left corner lies at {located(plan.map_origin)}; "
                  "env.start and env.dock count from that of the map's image")
    wide, high = figure_size(plan, LONGEST, 4.2)
    lines = wrapped(title, wide)
    margins = STRIP * max(wide, high) + 1.4 + LINE * (1 + lines.count("\n"))
    figure = Figure((wide + 0.8, high + margins), dpi=DOTS, layout="constrained")
    axes = figure.add_subplot()
    draw_plan(axes, plan, round(max(wide, high) * DOTS))
    add_scale_bar(axes, plan)
    mark_places(axes, plan)
    axes.grid(color="#9ca3af", linewidth=0.4, alpha=0.5)
    add_legend(figure, meanings(axes, plan))
    figure.suptitle(lines, fontsize=9)
    return figure
