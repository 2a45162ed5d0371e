"""Limits of GLB and glTF files: lengths of chunks, views and accessors, nodes that repeat, sizes of pictures."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path
from typing import Any

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.picture_limits import refuse_many_pixels

JSON, BIN = 0x4E4F534A, 0x004E4942
MOST_JSON = 64 << 20
COMPONENTS = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
PACKED = {"KHR_draco_mesh_compression": "Draco", "EXT_meshopt_compression": "meshopt", "KHR_texture_basisu": "Basis",
          "KHR_mesh_quantization": ""}
DEPTH = 200  # nodes within nodes


def refuse_gltf(path: Path, head: bytes, most_triangles: int) -> None:
    """Raise SceneError unless all that the file claims is there, and is not too much."""
    try:
        tree, binary = opened(path, head) if path.suffix.lower() == ".glb" else (read_tree(path), None)
        refuse_packed(path, tree)
        buffers = [buffer_of(path, number, item, binary) for number, item in enumerate(tree.get("buffers", []))]
        views = [view_of(item, buffers) for item in tree.get("bufferViews", [])]
        counts = [accessor_count(item, views) for item in tree.get("accessors", [])]
        drawn = sum(triangles(tree, node, counts, 0, set()) for node in roots(tree))
        if drawn > most_triangles:
            raise SceneError(f"{path} has {drawn} triangles; the most are {most_triangles}. Reduce them first.")
        refuse_pictures(path, tree, views)
    except (KeyError, IndexError, TypeError, AttributeError, ValueError, RecursionError, struct.error) as error:
        why = str(error) if isinstance(error, ValueError) and not isinstance(error, UnicodeError) else \
            f"something that it refers to is not there ({type(error).__name__} {error})"
        raise SceneError(f"{path} is broken: {why}.") from None


def opened(path: Path, head: bytes) -> tuple[dict[str, Any], bytes | None]:
    """The tree and the binary chunk of a GLB. Raises ValueError where lengths do not fit."""
    if len(head) < 20 or head[:4] != b"glTF":
        raise ValueError("it is no GLB file, which begins with glTF")
    version, length = struct.unpack_from("<II", head, 4)
    size = path.stat().st_size
    if version != 2:
        raise ValueError(f"it is glTF of version {version}, not 2")
    if length > size:
        raise ValueError(f"it is cut off, {size} bytes of {length}")
    raw = path.read_bytes()[:length]
    chunks: dict[int, bytes] = {}
    at = 12
    while at + 8 <= length:
        long, kind = struct.unpack_from("<II", raw, at)
        if at + 8 + long > length:
            raise ValueError(f"a chunk of {long} bytes does not fit into its {length}")
        chunks.setdefault(kind, raw[at + 8:at + 8 + long])
        at += 8 + long
    if JSON not in chunks:
        raise ValueError("it has no JSON chunk")
    return loaded(chunks[JSON]), chunks.get(BIN, b"")


def read_tree(path: Path) -> dict[str, Any]:
    """The tree of a GLB or glTF file, without its binary chunk. Raises ValueError for what is none."""
    with open(path, "rb") as file:
        if path.suffix.lower() != ".glb":
            return loaded(file.read())
        head = file.read(20)
        if len(head) < 20 or head[:4] != b"glTF":
            raise ValueError("it is no GLB file, which begins with glTF")
        return loaded(file.read(min(struct.unpack_from("<I", head, 12)[0], MOST_JSON + 1)))


def loaded(raw: bytes) -> dict[str, Any]:
    """The tree of glTF's JSON. Raises ValueError for what is none."""
    if len(raw) > MOST_JSON:
        raise ValueError(f"its JSON has {len(raw)} bytes, more than {MOST_JSON}")
    try:
        tree = json.loads(raw)
    except (ValueError, RecursionError):
        raise ValueError("its JSON cannot be read") from None
    if not isinstance(tree, dict):
        raise ValueError("its JSON is no object")
    return tree


def refuse_packed(path: Path, tree: dict[str, Any]) -> None:
    """Raise SceneError for a file that is packed in a way that trimesh does not unpack."""
    for name in tree.get("extensionsRequired", []):
        if PACKED.get(name, "another way"):
            raise SceneError(f"{path} is packed by {name}, which is not read here. Export it without compression, or "
                             "open it in Blender and export it as GLB.")


def buffer_of(path: Path, number: int, item: dict[str, Any], binary: bytes | None) -> bytes:
    """The bytes of a buffer: the binary chunk, a data URI, or a file beside. Raises ValueError where they are fewer
    than it claims, SceneError where the file is elsewhere."""
    uri, claimed = item.get("uri"), whole(item["byteLength"])
    if uri is None:
        if binary is None or number:
            raise ValueError(f"its buffer {number} is nowhere")
        held = binary
    else:
        held = resource(path, uri)
    if claimed > len(held):
        raise ValueError(f"a buffer claims {claimed} bytes and has {len(held)}")
    return held[:claimed]


def resource(path: Path, uri: str) -> bytes:
    """What a URI names: data in itself, or a file in the folder of the mesh. Raises ValueError or SceneError."""
    from curionav_cli.world.scan.limits import refuse_outside

    if uri.startswith("data:"):
        return base64.b64decode(uri.partition(",")[2], validate=False)
    refuse_outside(path, uri)
    if not (path.parent / uri).is_file():
        raise ValueError(f"it needs the file {uri[:80]} beside it, which is not there")
    return (path.parent / uri).read_bytes()


def view_of(item: dict[str, Any], buffers: list[bytes]) -> tuple[bytes, int, int]:
    """Buffer, offset and length of a view. Raises ValueError where it reaches beyond its buffer."""
    held, offset, length = buffers[whole(item["buffer"])], whole(item.get("byteOffset", 0)), whole(item["byteLength"])
    if offset + length > len(held):
        raise ValueError(f"a view of {length} bytes at {offset} reaches beyond its buffer of {len(held)}")
    return held, offset, length


def accessor_count(item: dict[str, Any], views: list[tuple[bytes, int, int]]) -> int:
    """How many elements an accessor has. Raises ValueError where its view has no room for them, or it has no view."""
    count, each = whole(item["count"]), COMPONENTS[item["componentType"]] * NUMBERS[item["type"]]
    if "bufferView" not in item:
        raise ValueError(f"an accessor of {count} elements has no data")
    length = views[whole(item["bufferView"])][2]
    if count * each + whole(item.get("byteOffset", 0)) > length:
        raise ValueError(f"an accessor of {count} elements does not fit into its {length} bytes")
    return count


def whole(number: Any) -> int:
    """A whole number that is not negative. Raises ValueError."""
    if isinstance(number, bool) or not isinstance(number, int) or number < 0:
        raise ValueError(f"{str(number)[:20]} stands where a size or an index is needed")
    return number


def roots(tree: dict[str, Any]) -> list[int]:
    """The nodes at the top of the file's scene; all meshes, where it has none."""
    scenes = tree.get("scenes", [])
    if scenes:
        return list(scenes[whole(tree.get("scene", 0))].get("nodes", []))
    return list(range(len(tree.get("nodes", []))))


def triangles(tree: dict[str, Any], number: int, counts: list[int], depth: int, seen: set[int]) -> int:
    """Triangles of a node and all below it. Raises ValueError for a node that hangs in two places."""
    if number in seen or depth > DEPTH:
        raise ValueError("its nodes are no tree")
    seen.add(whole(number))
    node, found = tree["nodes"][number], 0
    if "mesh" in node:
        for part in tree["meshes"][whole(node["mesh"])]["primitives"]:
            corners = counts[whole(part.get("indices", part["attributes"]["POSITION"]))]
            found += corners // 3 if part.get("mode", 4) == 4 else corners
    return found + sum(triangles(tree, child, counts, depth + 1, seen) for child in node.get("children", []))


def refuse_pictures(path: Path, tree: dict[str, Any], views: list[tuple[bytes, int, int]]) -> None:
    """Raise ValueError for pictures that together have too many pixels by their headers."""
    raw = []
    for item in tree.get("images", []):
        if "bufferView" in item:
            held, offset, length = views[whole(item["bufferView"])]
            raw.append(held[offset:offset + length])
        else:
            raw.append(resource(path, item["uri"]))
    refuse_many_pixels(raw)
