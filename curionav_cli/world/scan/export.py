"""Our own worlds as meshes: boxes, floor and ceiling of a scene with their materials, as GLB.

The ground truth of scans: the same cells, depth and colours come back (tests/world/scan/test_round_trip.py).
"""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.files import write_bytes
from curionav_cli.world.materials.materials import SIZE, picture
from curionav_cli.world.render.box_tables import (
    CEILING_LIGHT,
    FACE_LIGHT,
    FLOOR_LIGHT,
    STRETCH,
    TOP_LIGHT,
    UNDER_LIGHT,
)
from curionav_cli.world.render.texture_atlas import TEXEL, ceiling_picture, floor_picture
from curionav_cli.world.scan.gltf_writer import GlbWriter, Quads
from curionav_cli.world.scene.boxes import EAST, FIXED, NORTH, SOUTH, WEST, Boxes
from curionav_cli.world.scene.scene import Scene

BELOW, ABOVE = 4, 5  # the faces -z, +z, after those of boxes.py
LIGHT = (*FACE_LIGHT.tolist(), UNDER_LIGHT, TOP_LIGHT)
CORNERS = {  # which of low (0) and high (1) each corner takes in x, y, z, anticlockwise as seen from outside
    WEST: ((0, 1, 0), (0, 0, 0), (0, 0, 1), (0, 1, 1)), EAST: ((1, 0, 0), (1, 1, 0), (1, 1, 1), (1, 0, 1)),
    SOUTH: ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)), NORTH: ((1, 1, 0), (0, 1, 0), (0, 1, 1), (1, 1, 1)),
    BELOW: ((0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 0, 0)), ABOVE: ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)),
}
# Axis and sense of u, as box_tables has them.
ALONG = {WEST: (1, -1.0), EAST: (1, 1.0), SOUTH: (0, 1.0), NORTH: (0, -1.0)}


def export(scene: Scene, path: Path) -> int:
    """Write a scene as it stands; returns the number of triangles. Raises SceneError for a scan, which is a mesh."""
    if scene.view is not None:
        raise SceneError(f"{scene.name} is a mesh already. Export a world of boxes or a ROS map.")
    sheets = {"floor": floor_picture(scene), "ceiling": ceiling_picture(scene)}
    pictures = {name: np.rint(image).clip(0, 255).astype(np.uint8)[::-1] for name, image in sheets.items()}
    used = {scene.boxes.materials[number] for number in np.unique([*scene.boxes.sides.ravel(), *scene.boxes.top])}
    pictures |= {name: picture(name)[::-1] for name in used}
    writer, count = GlbWriter(pictures), 0
    for node, parts in [("room", planes(scene, pictures)), *objects(scene)]:
        writer.add(node, parts)
        count += sum(2 * len(part.corners) for part in parts)
    write_bytes(path, writer.bytes_of())
    return count


def planes(scene: Scene, pictures: dict[str, np.ndarray]) -> list[Quads]:
    """Floor and ceiling; their pictures reach a texel beyond the scene."""
    found = []
    for name, z, light, sense in (("floor", 0.0, FLOOR_LIGHT, 1), ("ceiling", scene.height, CEILING_LIGHT, -1)):
        low, high = np.array([0.0, 0.0, z]), np.array([*scene.size, z])
        corners = np.where(np.array(CORNERS[ABOVE])[::sense], high, low)[None]
        texel = np.ceil(np.array(scene.size) / texel_of(scene, pictures[name]))
        shape = np.array(pictures[name].shape[1::-1])
        found.append(Quads(name, name, light, corners, corners[..., :2] / texel_of(scene, pictures[name]) / shape))
        assert (texel + 2 == shape).all()
    return found


def texel_of(scene: Scene, image: np.ndarray) -> float:
    """Metres of a texel of a sheet."""
    from curionav_cli.world.render import texture_atlas as atlas

    finest = ((atlas.FLOOR_TEXEL, atlas.FLOOR_MOST), (atlas.CEILING_TEXEL, atlas.CEILING_MOST))
    sizes = [max(texel, float(np.sqrt(scene.size[0] * scene.size[1] / most))) for texel, most in finest]
    return next(size for size in sizes if round(np.ceil(scene.size[0] / size)) + 2 == image.shape[1])


def objects(scene: Scene) -> list[tuple[str, list[Quads]]]:
    """The boxes: what is fixed as one object, what moves each as one of its own, where it stands now."""
    names = {FIXED: "walls_and_furniture", **{number: item.name for number, item in enumerate(scene.items)}}
    found = []
    for number in np.unique(scene.boxes.item).tolist():
        parts = faces(scene.boxes, np.flatnonzero(scene.boxes.item == number))
        found.append((names[number], parts))
    return found


def faces(boxes: Boxes, which: np.ndarray) -> list[Quads]:
    """The faces of boxes by material and light; those that lie on the floor are left out."""
    groups: dict[tuple[str, int], list[tuple[np.ndarray, np.ndarray]]] = defaultdict(list)
    for box in which.tolist():
        low, high, fit = boxes.low[box], boxes.high[box], bool(boxes.fit[box])
        for face in (*ALONG, BELOW, ABOVE):
            if face == BELOW and low[2] <= 0.0:
                continue
            material = boxes.materials[boxes.sides[box, face] if face in ALONG else boxes.top[box]]
            corners = np.where(np.array(CORNERS[face]), high, low)
            groups[material, face].append((corners, texels(corners, low, high, face, fit) / SIZE))
    return [Quads(f"{material}_{face}", material, LIGHT[face], *map(np.stack, zip(*held, strict=True)))
            for (material, face), held in sorted(groups.items())]


def texels(corners: np.ndarray, low: np.ndarray, high: np.ndarray, face: int, fit: bool) -> np.ndarray:
    """(4, 2): the texel, across and up, at each corner of a face, by the rules of box_tables.py."""
    if face in ALONG:
        axis, sense = ALONG[face]
        start = (low if sense > 0 else high)[axis] if fit else 0.0
        scale = (STRETCH / (high[axis] - low[axis]) if fit else TEXEL) * sense
        rise = STRETCH / (high[2] - low[2]) if fit else TEXEL
        return np.stack([(corners[:, axis] - start) * scale, (corners[:, 2] - (low[2] if fit else 0.0)) * rise], axis=1)
    extent = high[:2] - low[:2]
    scale = STRETCH / extent if fit else np.minimum(TEXEL, STRETCH / extent)
    return (corners[:, :2] - low[:2]) * scale
