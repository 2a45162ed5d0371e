"""A look at a mesh file before it is read: sizes that its header claims beside those that it has.

A reader takes such sizes as they are, and a hundred bytes may claim a gigabyte. Raises SceneError, one line.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.companions import HEADER, PICTURE_KINDS, companions, named
from curionav_cli.world.scan.gltf_limits import refuse_gltf
from curionav_cli.world.scan.picture_limits import refuse_many_pixels

MOST_TRIANGLES = 20_000_000
MOST_BYTES = 4 << 30
MOST_ELEMENTS = 60_000_000  # vertices or faces that a header may announce
SIZES = {"char": 1, "uchar": 1, "int8": 1, "uint8": 1, "short": 2, "ushort": 2, "int16": 2, "uint16": 2, "int": 4,
         "uint": 4, "int32": 4, "uint32": 4, "float": 4, "float32": 4, "double": 8, "float64": 8, "int64": 8,
         "uint64": 8}
POINTER = b"version https://git-lfs"
KINDS = (".ply", ".glb", ".gltf", ".obj", ".stl")


def refuse_absent(path: Path) -> None:
    """Raise SceneError for a file that is not there, is empty or too large, or by its name is no mesh."""
    if not path.is_file():
        raise SceneError(f"There is no mesh {path}. env.mesh is the path of a {', '.join(KINDS)} file.")
    size = path.stat().st_size
    if path.suffix.lower() not in KINDS:
        raise SceneError(f"{path}: meshes are {', '.join(KINDS)} files; convert it to GLB first, with Blender say.")
    if size > MOST_BYTES:
        raise SceneError(f"{path} has {size / 1e9:.1f} GB; the most are {MOST_BYTES / 1e9:.1f}. Reduce it first.")
    if not size:
        raise SceneError(f"{path} is empty.")
    with open(path, "rb") as file:
        if file.read(len(POINTER)) == POINTER:
            raise SceneError(f"{path} is a pointer of Git LFS, not the mesh itself. Fetch it with git lfs pull.")


def refuse_broken(path: Path) -> None:
    """Raise SceneError for a file that is not there, is no mesh, was cut off, or claims more than it holds."""
    refuse_absent(path)
    kind, size = path.suffix.lower(), path.stat().st_size
    with open(path, "rb") as file:
        head = file.read(HEADER)
    if kind in (".glb", ".gltf"):
        refuse_gltf(path, head, MOST_TRIANGLES)
    elif kind == ".ply":
        refuse_ply(path, head, size)
    elif kind == ".stl":
        refuse_stl(path, head, size)
    else:
        refuse_obj(path, head)
    if kind in (".ply", ".obj"):  # those of glTF stand in its tree, which is checked above
        refuse_beside(path)


def refuse_ply(path: Path, head: bytes, size: int) -> None:
    """Raise SceneError unless the elements of a PLY's header fit into its bytes."""
    end = re.search(rb"end_header\r?\n", head)
    if not head.startswith(b"ply") or not end:
        raise SceneError(f"{path} is no PLY file: it does not begin with a header from ply to end_header.")
    lines = head[:end.start()].decode("ascii", "replace").split("\n")
    text, body, least = "format ascii" in head[:200].decode("ascii", "replace"), size - end.end(), 0
    names = set()
    for name, count, each in elements(lines, path):
        if count > MOST_ELEMENTS:
            raise SceneError(f"{path} announces {count} of {name}; the most are {MOST_ELEMENTS}.")
        names.add(name)
        least += count * (2 if text else each)
    if least > body:
        raise SceneError(f"{path} is cut off: {body} bytes for what needs at least {least}.")
    if "vertex" not in names or "face" not in names:
        raise SceneError(f"{path} holds no triangles. A cloud of points is no mesh: make one of it first, as "
                         "docs/scans.md says.")


def elements(lines: list[str], path: Path) -> Iterator[tuple[str, int, int]]:
    """Name, count and least bytes of each element of a PLY's header. Raises SceneError for a line that is none."""
    name, count, each = "", 0, 0
    for line in lines:
        words = line.split()
        try:
            if words[:1] == ["element"]:
                if name:
                    yield name, count, each
                name, count, each = words[1], int(words[2]), 0
                if count < 0:
                    raise ValueError
            elif words[:1] == ["property"]:
                each += SIZES[words[2] if words[1] == "list" else words[1]]
        except (IndexError, KeyError, ValueError):
            raise SceneError(f"{path} is broken: its header has the line {line.strip()[:60]!r}.") from None
    if name:
        yield name, count, each


def refuse_stl(path: Path, head: bytes, size: int) -> None:
    """Raise SceneError unless a binary STL has the bytes of its triangles; one in words begins with solid."""
    count = struct.unpack_from("<I", head, 80)[0] if len(head) >= 84 else 0
    if size == 84 + 50 * count and count:
        if count > MOST_TRIANGLES:
            raise SceneError(f"{path} has {count} triangles; the most are {MOST_TRIANGLES}. Reduce them first.")
        return
    if not (head[:5].lower() == b"solid" and b"facet" in head):
        raise SceneError(f"{path} is no STL file, or is cut off: {size} bytes for {count} triangles.")


def refuse_obj(path: Path, head: bytes) -> None:
    """Raise SceneError for an OBJ file that is no text."""
    if b"\0" in head:
        raise SceneError(f"{path} is no OBJ file: it is not text.")


def refuse_beside(path: Path) -> None:
    """Raise SceneError where a file that the mesh names is outside its folder, or its pictures are huge."""
    for name in named(path):
        refuse_outside(path, name)
    try:
        refuse_many_pixels(beside.read_bytes() for beside in companions(path)
                           if beside.suffix.lower() in PICTURE_KINDS)
    except ValueError as error:
        raise SceneError(f"{path} is broken: {error}.") from None


def refuse_outside(path: Path, name: str) -> None:
    """Raise SceneError for the name of a file that is not in the folder of the mesh, or below it."""
    beside = (path.parent / name).resolve()
    if Path(name).is_absolute() or not beside.is_relative_to(path.parent.resolve()):
        raise SceneError(f"{path} names a file outside its own folder, {name[:80]}. Bring all its files together.")
