"""Reading a mesh: PLY, GLB, glTF, OBJ and STL by trimesh, from the extra `scan`; limits.py looks at the file before."""

from __future__ import annotations

import gc
import hashlib
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.limits import MOST_TRIANGLES, refuse_broken
from curionav_cli.world.scan.mesh import Mesh
from curionav_cli.world.scan.tracer import extra

LARGEST = 4096  # texels of a picture's side; larger ones are halved
GREY = 176  # of a mesh without colours
DISPLAY = 2.2  # glTF multiplies light, and pictures hold its root


def read_mesh(path: Path) -> Mesh:
    """Read the triangles and colours of a file, in its own axes and units. Raises SceneError in one line."""
    refuse_broken(path)
    try:
        import trimesh
    except ImportError as error:
        raise extra(error) from None
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pieces = pieces_of(trimesh.load_scene(path, process=False))
    except MemoryError:
        raise SceneError(f"{path} needs more memory than there is. Reduce its triangles or textures.") from None
    except Exception as error:  # readers raise every kind of exception for broken files
        line = next(iter(str(error).splitlines()), "") or type(error).__name__
        raise SceneError(f"{path} is no mesh that can be read: {line[:200]}") from None
    finally:
        gc.collect()  # trimesh's objects hold one another, and their arrays are twice as wide as ours
    if not pieces:
        raise SceneError(f"{path} holds no triangles. A cloud of points is no mesh: make one of it first, as "
                         "docs/scans.md says.")
    return sound(joined(pieces), path)


def pieces_of(scene: Any) -> list[Mesh]:
    """The meshes of a trimesh.Scene, each where it stands."""
    return [piece(scene.geometry[name], np.asarray(matrix)) for matrix, name in
            (scene.graph[node] for node in sorted(scene.graph.nodes_geometry))
            if hasattr(scene.geometry[name], "faces") and len(scene.geometry[name].faces)]


def piece(part: Any, matrix: np.ndarray) -> Mesh:
    """One of the file's meshes in the file's frame. part: a trimesh.Trimesh; matrix: (4, 4), where it stands."""
    place, faces = np.asarray(part.vertices), np.asarray(part.faces, np.int32)
    vertices = (place @ matrix[:3, :3].T + matrix[:3, 3]).astype(np.float32)
    colour, texture = np.full((len(vertices), 3), GREY, np.uint8), np.full(len(faces), -1, np.int16)
    uv, images = np.zeros((len(vertices), 2), np.float32), tuple[np.ndarray, ...]()
    if part.visual.kind == "texture":
        image, factor = surface(part.visual.material)
        if image is not None and part.visual.uv is not None and len(part.visual.uv) == len(vertices):
            texture[:], uv = 0, np.asarray(part.visual.uv, np.float32)
            images = (dimmed(image, factor),)
        else:
            colour[:] = np.rint(255.0 * factor)
    elif part.visual.kind == "vertex":
        colour = np.asarray(part.visual.vertex_colors, np.uint8)[:, :3]
    elif part.visual.kind == "face":  # each triangle gets corners of its own
        colour = np.repeat(np.asarray(part.visual.face_colors, np.uint8)[:, :3], 3, axis=0)
        vertices, uv = vertices[faces.ravel()], np.zeros((3 * len(faces), 2), np.float32)
        faces = np.arange(len(vertices), dtype=np.int32).reshape(-1, 3)
    return Mesh(vertices, faces, colour, texture, images, uv)


def surface(material: Any) -> tuple[np.ndarray | None, np.ndarray]:
    """The picture of a material, (H, W, 3) uint8 or None, and the colour (3,) that it is multiplied by, 0 to 1."""
    image = getattr(material, "baseColorTexture", None)
    pbr = hasattr(material, "baseColorFactor")
    image = image if pbr else getattr(material, "image", None)
    factor = material.baseColorFactor if pbr else None
    if not pbr and image is None:
        factor = material.main_color
    light = np.ones(3) if factor is None else np.asarray(factor, np.float64)[:3] / 255.0
    return (None if image is None else pixels(image)), light ** (1.0 / DISPLAY) if pbr else light


def pixels(image: Any) -> np.ndarray:
    """(H, W, 3) uint8 of a PIL.Image; one with a side beyond LARGEST is halved until it has none."""
    image = image if image.mode == "RGB" else image.convert("RGB")
    while max(image.size) > LARGEST:
        image = image.reduce(2)
    return np.asarray(image)


def dimmed(image: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """A picture times a colour (3,), 0 to 1."""
    if (factor == 1.0).all():
        return image
    tables = np.rint(np.arange(256)[:, None] * factor).astype(np.uint8)
    return np.stack([tables[:, channel].take(image[..., channel]) for channel in range(3)], axis=-1)


def joined(pieces: list[Mesh]) -> Mesh:
    """One mesh of several; a picture that several share is kept once."""
    before = np.cumsum([0] + [len(part.vertices) for part in pieces])
    pictures: dict[str, tuple[int, np.ndarray]] = {}
    number = []
    for part in pieces:
        for image in part.textures:
            seen = f"{image.shape} {hashlib.sha256(np.ascontiguousarray(image).data).hexdigest()}"
            at, _ = pictures.setdefault(seen, (len(pictures), image))
            number.append(np.full(len(part.faces), at, np.int16))
        if not part.textures:
            number.append(part.texture)
    def stacked(name: str) -> np.ndarray:
        return np.concatenate([getattr(part, name) for part in pieces])
    faces = np.concatenate([part.faces + first for part, first in zip(pieces, before[:-1].tolist(), strict=True)])
    held = Mesh(stacked("vertices"), faces.astype(np.int32, copy=False), stacked("colour"), np.concatenate(number),
                tuple(image for _, image in pictures.values()), stacked("uv"))
    return held if held.textures else replace(held, texture=held.texture[:0].copy(), uv=held.uv[:0].copy())


def sound(mesh: Mesh, path: Path) -> Mesh:
    """The mesh, checked: indices that exist, finite places, no more triangles than MOST_TRIANGLES."""
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise SceneError(f"{path} is broken: a triangle has a corner that is not among its {len(mesh.vertices)}.")
    if len(mesh.faces) > MOST_TRIANGLES:
        raise SceneError(f"{path} has {len(mesh.faces)} triangles; the most are {MOST_TRIANGLES}. Reduce them first.")
    if not np.isfinite(mesh.vertices[np.unique(mesh.faces)] if len(mesh.faces) < len(mesh.vertices) / 3
                       else mesh.vertices).all():
        raise SceneError(f"{path} is broken: some of its places are not finite numbers.")
    return mesh
