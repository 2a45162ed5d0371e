"""Where a robot can stand in a mesh: floor under the centre of a cell, and nothing within its radius.

Beside what Recast does for Habitat: docs/scans.md.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.mesh import Mesh
from curionav_cli.world.scan.obstacles import obstacle_points
from curionav_cli.world.scan.tracer import Tracer
from curionav_cli.world.scene.boxes import Box
from curionav_cli.world.scene.reachability import grid_shape
from curionav_cli.world.scene.rectangle_cover import cover
from curionav_cli.world.settings import Scan

TOUCH = 2e-4  # metres: obstacles are points SPACING apart, and coordinates in files have 24 bits
UNDER = 1e-4  # metres: what begins at agent_height is passed under
FINE = 4  # squares along a cell, in which obstacles are kept for sensors
LONGEST = 160  # fine squares of a rectangle
CELL = 0.05  # metres, where env.cell is null
AROUND = 1.0  # metres below the floor and above the robot: what lies there belongs to the storey
REACH = 6.0  # metres, more than any radius


@dataclass(frozen=True)
class Footing:
    """The floor of a mesh on cells (rows, columns) of `cell` metres.

    supported: floor lies under the centre; solid: an obstacle is in it; clear: supported, and no obstacle within the
    robot's radius. fine (rows * FINE, columns * FINE): squares with an obstacle.
    """

    cell: float
    supported: np.ndarray
    solid: np.ndarray
    clear: np.ndarray
    fine: np.ndarray

    @property
    def holes(self) -> np.ndarray:
        """(rows, columns) bool: cells without floor or obstacle, inside the building and beside free floor."""
        built = self.supported | self.solid
        label, _ = ndimage.label(ndimage.binary_fill_holes(built) & ~built)
        beside = np.unique(label[ndimage.binary_dilation(self.supported & ~self.solid)])
        return np.isin(label, beside[beside > 0])

    def obstacles(self, height: float) -> list[Box]:
        """Boxes over the squares with an obstacle, from the corner of the grid, for collisions and sensors."""
        side = self.cell / FINE
        return [Box((column0 * side, row0 * side, 0.0), (column1 * side, row1 * side, height), ("metal",) * 4, "metal")
                for row0, column0, row1, column1 in cover(self.fine, LONGEST, hidden=True).tolist()]


def footing(mesh: Mesh, tracer: Tracer, shape: tuple[int, int], env: Scan) -> Footing:
    """Find where a robot can stand in a mesh whose floor is at height 0 and whose lowest cell begins at 0, 0.

    shape: (rows, columns) of the cells. Raises SceneError where that is nowhere.
    """
    cell, low, high = cell_of(env), env.step, env.agent_height - UNDER
    x, y = ((np.arange(shape[1 - axis]) + 0.5) * cell for axis in (0, 1))
    centres = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    height, steep = beneath(tracer, centres, high, env)
    covered = height > low
    supported: np.ndarray = np.abs(height) <= env.step
    supported &= ~(steep & (rise(height.reshape(shape)) > math.tan(math.radians(env.slope)) * cell).ravel())
    points = obstacle_points(mesh, low, high)
    fine = touched(points, cell / FINE, (shape[0] * FINE, shape[1] * FINE))
    clear = supported.copy()
    clear[supported] = away(points, centres[supported]) > env.radius + TOUCH if len(points) else True
    if not bool(clear.any()):
        raise SceneError(f"{env.mesh}: on this floor a robot of radius {env.radius:g} m fits nowhere. Lower "
                         "env.radius, raise env.step, or choose another env.storey. Or another axis points "
                         "up: env.up=z (y, x, -z ...).")
    fine |= np.kron(covered.reshape(shape), np.ones((FINE, FINE), bool))
    solid = np.logical_or.reduce(fine.reshape(shape[0], FINE, shape[1], FINE), axis=(1, 3))
    return Footing(cell, supported.reshape(shape), solid, clear.reshape(shape), fine)


def cell_of(env: Scan) -> float:
    """The side of a cell, metres."""
    return env.cell or CELL


def grid(mesh: Mesh, level: float, env: Scan) -> tuple[tuple[float, float], tuple[int, int]]:
    """Corner, metres, and (rows, columns) of cells around the storey at `level`; whole cells from the file's origin.

    Raises SceneError where they are too many, or none.
    """
    cell, z = cell_of(env), mesh.vertices[:, 2]
    here = mesh.vertices[(z > level - AROUND) & (z < level + AROUND + env.agent_height), :2].astype(np.float64)
    if not len(here):
        raise SceneError(f"{env.mesh}: Nothing of it is at the height {level:g} m. Leave out env.level: curionav sheet "
                         "says where its floors are.")
    margin = math.ceil(env.radius / cell) + 1
    low = np.floor((here.min(axis=0) + TOUCH) / cell) - margin
    top = np.ceil((here.max(axis=0) - TOUCH) / cell) + margin
    columns, rows = (top - low).astype(int).tolist()
    grid_shape((columns * cell, rows * cell), cell)
    return (float(low[0]) * cell, float(low[1]) * cell), (rows, columns)


def beneath(tracer: Tracer, centres: np.ndarray, high: float, env: Scan) -> tuple[np.ndarray, np.ndarray]:
    """Height of the first surface under points (n, 2) at height `high`, -inf for none; and whether it is too steep."""
    origins = np.column_stack([centres, np.full(len(centres), high)]).astype(np.float32)
    hits = tracer.cast(origins, np.tile(np.array([0.0, 0.0, -1.0], np.float32), (len(origins), 1)))
    height = np.where(hits.face < 0, -np.inf, high - hits.far.astype(np.float64))
    length = np.linalg.norm(hits.cross, axis=1)
    return height, np.abs(hits.cross[:, 2]) < math.cos(math.radians(env.slope)) * length


def rise(height: np.ndarray) -> np.ndarray:
    """(rows, columns): the largest difference in height to a cell beside; a scan's noise tilts single triangles."""
    found = np.zeros(height.shape)
    with np.errstate(invalid="ignore"):  # -inf beside -inf: no floor at all
        for axis in (0, 1):
            step = np.nan_to_num(np.abs(np.diff(height, axis=axis)), nan=0.0, posinf=np.inf)
            before, after = ([(0, 0), (0, 0)] for _ in range(2))
            before[axis], after[axis] = (1, 0), (0, 1)
            found = np.maximum(found, np.maximum(np.pad(step, before), np.pad(step, after)))
    return found


def away(points: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Metres from each centre to the nearest of the points, inf beyond REACH."""
    return cKDTree(points, balanced_tree=False).query(centres, distance_upper_bound=REACH)[0]


def touched(points: np.ndarray, side: float, shape: tuple[int, int]) -> np.ndarray:
    """(rows, columns) bool: squares that hold a point."""
    column, row = np.floor(points / side).astype(int).T
    held = np.zeros(shape, bool)
    inside = (row >= 0) & (row < shape[0]) & (column >= 0) & (column < shape[1])
    held[row[inside], column[inside]] = True
    return held
