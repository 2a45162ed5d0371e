"""A mesh as the site of a scene: its floor as cells, its obstacles as boxes, its picture from above."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.records import Pose
from curionav_cli.world.scan.cache import surveyed
from curionav_cli.world.scan.survey import Survey
from curionav_cli.world.scan.texels import Texels
from curionav_cli.world.scan.tracer import Tracer
from curionav_cli.world.scene.ground import Ground, Site
from curionav_cli.world.settings import Scan

LISTS = ("size", "map", "overlay", "rooms", "walls", "solids", "posters", "lamps", "furniture", "repeat", "tune",
         "light", "moves")
UNSET = "REPLICA_ROOT"  # stands in a path where that variable is not set


@dataclass(frozen=True)
class ScanView:
    """What draws a scan: rays into its triangles and their colours, in the scene's frame. triangles: how many."""

    triangles: int
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
    found, tracer, texels = surveyed(mesh_path(env), env)
    return site_of(found, env), ScanView(len(found.mesh.faces), tracer, texels, env.haze, found.about)


def mesh_path(env: Scan) -> Path:
    """The file of the mesh. Raises SceneError where none is named."""
    if not env.mesh:
        raise SceneError("env=scan needs the file of a mesh: env.mesh=FILE.glb (PLY, glTF, OBJ and STL too).")
    path = Path(env.mesh).expanduser()
    if UNSET in path.parts:
        raise SceneError(f"env={env.name} needs Replica, which you have to bring: export {UNSET}=FOLDER, the one with "
                         f"{'/'.join(path.parts[-2:])} in it. docs/scans.md says where it is to be had.")
    return path


def site_of(found: Survey, env: Scan) -> Site:
    """The site: boxes for sensors, cells for the rest."""
    floor, corner = found.footing, found.corner
    rows, columns = floor.clear.shape
    ground = Ground(np.zeros((1, 1), np.int64), max(rows, columns) * floor.cell, ("concrete",))
    return Site((columns * floor.cell, rows * floor.cell), floor.cell, floor.obstacles(env.agent_height), ground,
                floor=floor.supported | floor.solid, origin=Pose(*corner, 0.0), corner=corner,
                solid=floor.solid, clear=floor.clear, picture=found.picture)
