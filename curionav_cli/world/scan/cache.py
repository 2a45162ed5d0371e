"""Surveys of scans, kept in the user's cache folder by a checksum of the files and of the settings that shape them."""

from __future__ import annotations

import hashlib
import json
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from curionav_cli.errors import RunFolderError
from curionav_cli.files import read_arrays, write_arrays
from curionav_cli.places import cache_dir
from curionav_cli.world.scan.companions import companions
from curionav_cli.world.scan.footing import Footing
from curionav_cli.world.scan.limits import refuse_absent
from curionav_cli.world.scan.mesh import Mesh
from curionav_cli.world.scan.survey import Survey, survey
from curionav_cli.world.scan.texels import Texels
from curionav_cli.world.scan.tracer import Tracer, extra
from curionav_cli.world.settings import Scan

RULES = 1  # raised when the same file and settings make another survey
SHAPING = ("up", "scale", "storey", "level", "step", "slope", "cell", "radius", "agent_height")
KEPT = 8  # surveys, the newest used; older ones are removed
MESH = ("vertices", "faces", "colour", "texture", "uv")
FLOOR = ("supported", "solid", "clear", "fine")


def surveyed(path: Path, env: Scan) -> tuple[Survey, Tracer, Texels]:
    """The survey of a file, from the cache where it is there and whole; also what draws it. Raises SceneError."""
    refuse_absent(path)
    kept = cache_dir("scans") / f"{key(path, env)}.npz"
    found = read(kept)
    if found:
        kept.touch()
        return found, Tracer(found.mesh), Texels(found.mesh)
    found, tracer, texels = survey(path, env)
    try:
        write(kept, found)
    except OSError as error:
        line = f"kept for the next run it could not be: {error}"
        return Survey(found.mesh, found.footing, found.corner, found.picture, (*found.about, line)), tracer, texels
    return found, tracer, texels


def key(path: Path, env: Scan) -> str:
    """SHA-256 of all that shapes a survey: the file, those that it names, settings, our rules, and its reader."""
    try:
        beside = companions(path)
    except ValueError:  # its reader says what is wrong with it
        beside = []
    try:
        readers = [version("trimesh"), version("embreex")]
    except PackageNotFoundError as error:
        raise extra(ImportError(name=error.name)) from None
    sums = {file.name: digest(file) for file in beside}
    told = [RULES, readers, path.suffix.lower(), digest(path), sums, [getattr(env, name) for name in SHAPING]]
    return hashlib.sha256(json.dumps(told).encode()).hexdigest()[:32]


def digest(path: Path) -> str:
    """SHA-256 of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read(path: Path) -> Survey | None:
    """A survey that `write` wrote; None where it is not there or damaged."""
    if not path.is_file():
        return None
    try:
        held = read_arrays(path, (*MESH, *FLOOR, "picture", "numbers"))
        told = json.loads(str(held["numbers"]))
        pictures = read_arrays(path, tuple(f"texture_{at}" for at in range(told["textures"])))
    except (RunFolderError, ValueError, KeyError, TypeError):
        return None
    mesh = Mesh(**{name: held[name] for name in MESH}, textures=tuple(pictures.values()))
    floor = Footing(told["cell"], *(held[name] for name in FLOOR))
    return Survey(mesh, floor, (told["corner"][0], told["corner"][1]), held["picture"], tuple(told["about"]))


def write(path: Path, found: Survey) -> None:
    """Write a survey, whole or not at all, and remove the oldest beyond KEPT. Raises OSError."""
    told = {"cell": found.footing.cell, "corner": found.corner, "about": found.about,
            "textures": len(found.mesh.textures)}
    held = {name: getattr(found.mesh, name) for name in MESH} | {name: getattr(found.footing, name) for name in FLOOR}
    held |= {f"texture_{at}": image for at, image in enumerate(found.mesh.textures)}
    path.parent.mkdir(parents=True, exist_ok=True)
    write_arrays(path, {**held, "picture": found.picture, "numbers": np.array(json.dumps(told))}, level=0)
    newest = sorted(path.parent.glob("*.npz"), key=lambda file: file.stat().st_mtime, reverse=True)
    for old in newest[KEPT:]:
        old.unlink(missing_ok=True)
