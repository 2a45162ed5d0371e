"""A mesh as the site of a scene: its floor as cells, its obstacles as boxes, its picture from above."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy import ndimage

from curionav_cli.errors import SceneError
from curionav_cli.records import Pose
from curionav_cli.world.render.texture_atlas import unpack
from curionav_cli.world.scan.footing import Footing, footing, grid
from curionav_cli.world.scan.mesh import Mesh
from curionav_cli.world.scan.reader import read_mesh
from curionav_cli.world.scan.storeys import chosen_level
from curionav_cli.world.scan.texels import Texels
from curionav_cli.world.scan.tracer import Tracer
from curionav_cli.world.scan.upright import upright
from curionav_cli.world.scene.ground import Ground, Site
from curionav_cli.world.settings import Scan

LISTS = ("size", "map", "overlay", "rooms", "walls", "solids", "posters", "lamps", "furniture", "repeat", "tune",
         "light", "moves")
UNSET = "REPLICA_ROOT"  # stands in a path where that variable is not set
PICTURE = 0.025  # metres of a pixel seen from above
MOST_PIXELS = 4_000_000
CUT = 1.5  # metres above the floor, or agent_height: what is higher is not in the picture from above


@dataclass(frozen=True)
class ScanView:
    """What draws a scan: its mesh in the scene's frame (x, y from the lowest cell, z from the floor), and its rays."""

    mesh: Mesh
    tracer: Tracer
    texels: Texels
    haze: float
    about: tuple[str, ...]  # what was found in the file, a line each


def scan_site(env: Scan) -> tuple[Site, ScanView]:
    """The site of env.mesh and what draws it. Raises SceneError."""
    for key in LISTS:
        if getattr(env, key):
            raise SceneError(f"env.{key}: a scan is seen as it was scanned; nothing is added to it. Set env.{key} in "
                             "a world of its own.")
    if not env.mesh:
        raise SceneError("env=scan needs the file of a mesh: env.mesh=FILE.glb (PLY, glTF, OBJ and STL too).")
    path = Path(env.mesh).expanduser()
    if UNSET in path.parts:
        raise SceneError(f"env={env.name} needs Replica, which you have to bring: export {UNSET}=FOLDER, the one with "
                         f"{'/'.join(path.parts[-2:])} in it. docs/scans.md says where it is to be had.")
    mesh, tilt = upright(read_mesh(path), env)
    level, floors = chosen_level(mesh, env)
    corner, shape = grid(mesh, level, env)
    mesh = mesh.moved((-corner[0], -corner[1], -level))
    tracer = Tracer(mesh)
    found = footing(mesh, tracer, shape, env)
    view = ScanView(mesh, tracer, Texels(mesh), env.haze, about(mesh, tilt, level, floors, found))
    return site_of(found, corner, env, from_above(view, found, max(CUT, env.agent_height))), view


def site_of(found: Footing, corner: tuple[float, float], env: Scan, picture: np.ndarray) -> Site:
    """The site: boxes for sensors, cells for the rest. corner: of the lowest cell in the file's axes, metres."""
    rows, columns = found.clear.shape
    ground = Ground(np.zeros((1, 1), np.int64), max(rows, columns) * found.cell, ("concrete",))
    return Site((columns * found.cell, rows * found.cell), found.cell, found.obstacles(env.agent_height), ground,
                floor=found.supported | found.solid, origin=Pose(*corner, 0.0), corner=corner,
                solid=found.solid, clear=found.clear, picture=picture)


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


def from_above(view: ScanView, found: Footing, cut: float) -> np.ndarray:
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
        hits = view.tracer.cast(origins, directions)
        below = hits.far > cut + 1.0  # another storey, seen through a hole
        hits = hits._replace(face=np.where(below, -1, hits.face))
        unpack(view.texels.look_up(hits, directions, pixel / cut), image[at:at + 64])
    return image
