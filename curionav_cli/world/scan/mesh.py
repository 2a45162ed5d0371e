"""A mesh of triangles with its colours, as it comes from a file and as a world uses it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

AXES = {  # rows: the file's axes that become x, y and z of the world, z up; each keeps the handedness
    "z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)), "y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
    "x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)), "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)), "-x": ((0, 0, 1), (0, 1, 0), (-1, 0, 0)),
}

PART = 100_000  # triangles at once, which bounds the memory for their corners


@dataclass(frozen=True)
class Mesh:
    """V vertices and F triangles. vertices (V, 3) float32, metres; faces (F, 3) int32.

    colour (V, 3) uint8 sRGB, read where texture is -1; texture (F,) int16 indexes `textures`, images (H, W, 3) uint8;
    uv (V, 2) float32, v upwards. Without textures texture and uv are empty.
    """

    vertices: np.ndarray
    faces: np.ndarray
    colour: np.ndarray
    texture: np.ndarray
    textures: tuple[np.ndarray, ...]
    uv: np.ndarray

    def turned(self, rotation: np.ndarray, scale: float = 1.0) -> Mesh:
        """The mesh turned by a (3, 3) matrix, then scaled."""
        return replace(self, vertices=(self.vertices @ (np.asarray(rotation, np.float32).T * np.float32(scale))))

    def moved(self, by: tuple[float, float, float]) -> Mesh:
        """The mesh shifted by a vector, metres."""
        return replace(self, vertices=(self.vertices.astype(np.float64) + by).astype(np.float32))

    def corners(self, which: np.ndarray | slice = slice(None)) -> np.ndarray:
        """(n, 3, 3) float32: the corners of triangles."""
        return self.vertices[self.faces[which]]

    def crosses(self) -> np.ndarray:
        """(F, 3) float32: normals, twice as long as their triangle's area."""
        found = np.empty((len(self.faces), 3), np.float32)
        for at in range(0, len(found), PART):
            a, b, c = self.corners(slice(at, at + PART)).transpose(1, 0, 2)
            found[at:at + PART] = np.cross(b - a, c - a)
        return found
