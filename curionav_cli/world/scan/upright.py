"""The frame of a scan: which axis is up, how long a unit is, and by how much the scanner was held askew."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.mesh import AXES, Mesh
from curionav_cli.world.settings import Scan

Y_UP = (".glb", ".gltf", ".obj")  # glTF by its standard, OBJ by custom
LARGEST = 500.0  # metres: the longest building that is believed
TILTED, LEVEL = 15.0, 3.0  # degrees: surfaces taken for level at first, and once the tilt is known
LEAST_TILT = 0.1  # degrees; less is left as it is


def upright(mesh: Mesh, env: Scan) -> tuple[Mesh, float]:
    """The mesh in metres with z up, and the tilt that was taken out, degrees. Raises SceneError."""
    up = env.up if env.up != "auto" else "y" if Path(str(env.mesh)).suffix.lower() in Y_UP else "z"
    mesh = mesh.turned(np.array(AXES[up]), env.scale or 1.0)
    extent = np.ptp(mesh.vertices, axis=0)
    if not LARGEST > extent.max() > 0.5:
        unit = "x".join(f"{side:.4g}" for side in extent)
        raise SceneError(f"{env.mesh}: {unit} m is no building. Say how many metres one unit of the file is, as in "
                         f"env.scale={0.001 if extent.max() > LARGEST else 1000 if extent.max() < 0.05 else 10}.")
    normal = mesh.crosses()
    tilt = tilt_of(normal)
    angle = math.degrees(math.acos(min(1.0, float(tilt[2]))))
    if angle < LEAST_TILT:
        return mesh, 0.0
    return mesh.turned(levelling(tilt)), angle


def tilt_of(normal: np.ndarray) -> np.ndarray:
    """(3,): the unit vector at right angles to the floors, given normals (F, 3) as long as areas."""
    normal = np.where(normal[:, 2:] < 0.0, -normal, normal)
    area = np.linalg.norm(normal, axis=1)
    up = np.array([0.0, 0.0, 1.0])
    for within in (TILTED, LEVEL, LEVEL):
        chosen = normal @ up > math.cos(math.radians(within)) * area
        if not chosen.any():
            return up
        mean = np.median(normal[chosen] / area[chosen, None], axis=0) if within == TILTED else \
            normal[chosen].sum(axis=0, dtype=np.float64)
        up = mean / np.linalg.norm(mean)
    return up


def levelling(up: np.ndarray) -> np.ndarray:
    """The (3, 3) rotation that turns the unit vector `up` to z by the shortest way."""
    axis = np.cross(up, (0.0, 0.0, 1.0))
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + cross + cross @ cross / (1.0 + up[2])
