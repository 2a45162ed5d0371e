"""PNG pictures for the page of `curionav watch`: the heatmap so far, and camera images beside predictions."""

from __future__ import annotations

import cv2
import numpy as np
from matplotlib.colors import LogNorm, to_rgb

from curionav_cli.records import FloorPlan
from curionav_cli.results import floor_plans, plots
from curionav_cli.results.coverage import Coverage

LONGEST = 640  # dots of the longer side of a heatmap, about
COLOURS = np.array([to_rgb(kind.color) for kind in floor_plans.KINDS])


def heatmap(coverage: Coverage) -> bytes:
    """Visits of every square of cells over the floor plan, on a log scale; start and dock are marked."""
    plan, square = coverage.plan, plots.block_side(coverage.plan)
    high, wide = plan.solid.shape
    visits = np.kron(plots.blocks(coverage), np.ones((square, square), np.int64))[:high, :wide]
    picture = COLOURS[floor_plans.kinds(plan)]  # (rows, columns, 3)
    seen = (visits > 0) & ~plan.solid
    picture[seen] = plots.VISITS(LogNorm(1, max(2, int(visits.max())))(visits[seen]))[:, :3]
    rows, columns = floor_plans.window(plan)
    cropped = picture[rows, columns][::-1]
    side = max(1, round(LONGEST / max(cropped.shape[:2])))
    large = np.repeat(np.repeat((cropped * 255).astype(np.uint8), side, 0), side, 1)
    mark_places(large, plan, (rows.stop, columns.start), side)
    return png(large)


def mark_places(picture: np.ndarray, plan: FloorPlan, corner: tuple[int, int], side: int) -> None:
    """Draw discs at start and dock. corner: (row, column) of the upper left cell; side: dots of a cell."""
    for pose, (_, colour) in ((plan.start, floor_plans.START), (plan.dock, floor_plans.DOCK)):
        if pose is not None:
            x, y = (pose.x / plan.cell - corner[1]) * side, (corner[0] - pose.y / plan.cell) * side
            red, green, blue = (int(255 * part) for part in to_rgb(colour))
            for radius, ink in ((9, (255, 255, 255)), (6, (red, green, blue))):
                cv2.circle(picture, (round(x), round(y)), radius, ink, -1, cv2.LINE_AA)


def png(image: np.ndarray) -> bytes:
    """An RGB image, (rows, columns, 3) uint8, as PNG."""
    return cv2.imencode(".png", np.ascontiguousarray(image[..., ::-1]))[1].tobytes()
