"""What a mesh holds: the frame, the floor, its cells, its picture from above; found once, then kept (cache.py)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage

from curionav_cli.world.render.texture_atlas import unpack
from curionav_cli.world.scan.footing import Footing, footing, grid
from curionav_cli.world.scan.mesh import Mesh
from curionav_cli.world.scan.reader import read_mesh
from curionav_cli.world.scan.storeys import chosen_level
from curionav_cli.world.scan.texels import Texels
from curionav_cli.world.scan.tracer import Tracer
from curionav_cli.world.scan.upright import upright
from curionav_cli.world.settings import Scan

PICTURE = 0.025  # metres of a pixel seen from above
MOST_PIXELS = 4_000_000
CUT = 1.5  # metres above the floor, or agent_height: what is higher is not in the picture from above


@dataclass(frozen=True)
class Survey:
    """A mesh in the scene's frame, x and y from the lowest cell and z from the floor, and what was found in it.

    corner: of the lowest cell in the file's axes, metres; picture (rows, columns, 3) uint8: from above; about: lines
    for a reader.
    """

    mesh: Mesh
    footing: Footing
    corner: tuple[float, float]
    picture: np.ndarray
    about: tuple[str, ...]


def survey(path: Path, env: Scan) -> tuple[Survey, Tracer, Texels]:
    """Read a file and find its floor; also what draws it. Raises SceneError."""
    mesh, tilt = upright(read_mesh(path), env)
    level, floors = chosen_level(mesh, env)
    corner, shape = grid(mesh, level, env)
    mesh = mesh.moved((-corner[0], -corner[1], -level))
    tracer, texels = Tracer(mesh), Texels(mesh)
    found = footing(mesh, tracer, shape, env)
    picture = from_above(tracer, texels, found, max(CUT, env.agent_height))
    return Survey(mesh, found, corner, picture, about(mesh, tilt, level, floors, found)), tracer, texels


def about(mesh: Mesh, tilt: float, level: float, floors: list[float], found: Footing) -> tuple[str, ...]:
    """What was found in the file, a line each."""
    holes = ndimage.label(found.holes)[1]
    lines = [f"{len(mesh.faces):,} triangles, {len(mesh.textures)} textures",
             f"floor at {level:.2f} m; floors in the file: " + ", ".join(f"{height:.2f} m" for height in floors)]
    if tilt:
        lines.append(f"a tilt of {tilt:.1f} degrees was taken out")
    if holes:
        area = found.holes.sum() * found.cell**2
        lines.append(f"{holes} hole{'s' * (holes > 1)} in the scanned floor, {area:.2f} m2 in all, are walls")
    return tuple(lines)


def from_above(tracer: Tracer, texels: Texels, found: Footing, cut: float) -> np.ndarray:
    """(rows, columns, 3) uint8: the mesh from above without what is higher than `cut`; row 0 is the lowest."""
    rows, columns = (side * found.cell for side in found.clear.shape)
    pixel = max(PICTURE, float(np.sqrt(rows * columns / MOST_PIXELS)))
    x, y = (np.arange(max(1, round(side / pixel))) + 0.5 for side in (columns, rows))
    x, y = x * columns / len(x), y * rows / len(y)
    down = np.array([0.0, 0.0, -1.0], np.float32)
    image = np.empty((len(y), len(x), 3), np.uint8)
    for at in range(0, len(y), 64):
        places = np.stack(np.meshgrid(x, y[at:at + 64]), axis=-1).reshape(-1, 2)
        origins = np.column_stack([places, np.full(len(places), cut)]).astype(np.float32)
        directions = np.tile(down, (len(origins), 1))
        hits = tracer.cast(origins, directions)
        below = hits.far > cut + 1.0  # another storey, seen through a hole
        hits = hits._replace(face=np.where(below, -1, hits.face))
        unpack(texels.look_up(hits, directions, pixel / cut), image[at:at + 64])
    return image
