"""The files that a mesh names: materials and pictures of OBJ, buffers and pictures of glTF, the picture of a PLY."""

from __future__ import annotations

import re
from pathlib import Path

from curionav_cli.world.scan.gltf_limits import read_tree

HEADER = 1 << 16  # bytes of a PLY's header at most
MATERIALS = re.compile(rb"(?mi)^[ \t]*mtllib[ \t]+(.+?)[ \t\r]*$")
PICTURES = re.compile(rb"(?mi)^[ \t]*map_kd[ \t]+(.+?)[ \t\r]*$")
PICTURE = re.compile(rb"(?mi)^comment[ \t]+TextureFile[ \t]+(.+?)[ \t\r]*$")
PICTURE_KINDS = (".png", ".jpg", ".jpeg", ".webp", ".bmp", ".tga", ".tif", ".tiff")


def named(path: Path) -> list[str]:
    """The names as they stand in the file, in their order; none twice. Raises ValueError for glTF that is none."""
    kind = path.suffix.lower()
    if kind == ".obj":
        found = text_names(MATERIALS, path.read_bytes())
        found += [name for library in found if (path.parent / library).is_file()
                  for name in text_names(PICTURES, (path.parent / library).read_bytes())]
    elif kind == ".ply":
        with open(path, "rb") as file:
            found = text_names(PICTURE, file.read(HEADER).partition(b"end_header")[0])
    elif kind in (".glb", ".gltf"):
        tree = read_tree(path)
        held = [item for key in ("buffers", "images") for item in tree.get(key, [])]
        found = [item["uri"] for item in held if not item.get("uri", "data:").startswith("data:")]
    else:
        found = []
    return list(dict.fromkeys(found))


def companions(path: Path) -> list[Path]:
    """Those of the named files that are there. Raises ValueError for glTF that is none."""
    return [beside for name in named(path) if (beside := path.parent / name).is_file()]


def text_names(pattern: re.Pattern[bytes], raw: bytes) -> list[str]:
    """What a pattern names in the bytes of a text."""
    return [name.decode("utf-8", "replace") for name in pattern.findall(raw)]
