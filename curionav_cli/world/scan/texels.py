"""The colours of a mesh: its pictures with halved copies as one array, and a look-up for the hits of rays."""

from __future__ import annotations

import numpy as np

from curionav_cli.world.scan.mesh import Mesh
from curionav_cli.world.scan.tracer import Hits

NOTHING = np.float32([188, 192, 196])  # what is seen through a hole: the haze of the other worlds
LARGEST = 4096  # texels of a picture's side; larger ones are halved
LEVELS = 8


class Texels:
    """Looks up colours. texels (n, 3) uint8: level by level, picture by picture."""

    def __init__(self, mesh: Mesh):
        self._mesh = mesh
        pyramids = [pyramid(image) for image in mesh.textures]
        flat = [level for levels in pyramids for level in levels]
        sizes = np.array([[level.shape[:2] for level in levels] for levels in pyramids], np.int32)
        self._size = sizes.reshape(-1, LEVELS, 2)
        first = np.cumsum([0] + [level.shape[0] * level.shape[1] for level in flat])[:-1]
        self._first = first.astype(np.int64).reshape(-1, LEVELS)
        self._texels = np.concatenate([level.reshape(-1, 3) for level in flat]) if flat else np.zeros((1, 3), np.uint8)
        self._density = density(mesh, self._size[:, 0]) if flat else np.zeros(len(mesh.faces), np.float32)
        self.plain = not flat

    def look_up(self, hits: Hits, directions: np.ndarray, pixel: float) -> np.ndarray:
        """(N, 3) float32: the colours, 0 to 255, that rays meet. pixel: width of one at depth 1."""
        mesh = self._mesh
        corner = mesh.faces[hits.face]  # of those without a hit the last triangle's, painted over below
        first = np.float32(1.0) - hits.u - hits.v
        weights = np.stack([first, hits.u, hits.v], axis=1)
        colour = np.einsum("nk,nkc->nc", weights, mesh.colour[corner], dtype=np.float32)
        if not self.plain:
            textured = np.flatnonzero((mesh.texture[hits.face] >= 0) & (hits.face >= 0))
            colour[textured] = self._textured(Hits(*(part[textured] for part in hits)), corner[textured],
                                              weights[textured], directions[textured], pixel)
        colour[hits.face < 0] = NOTHING
        return colour

    def _textured(self, hits: Hits, corner: np.ndarray, weights: np.ndarray, directions: np.ndarray,
                  pixel: float) -> np.ndarray:
        mesh = self._mesh
        uv = np.einsum("nk,nkc->nc", weights, mesh.uv[corner])
        square = np.einsum("nc,nc->n", hits.cross, hits.cross) * np.einsum("nc,nc->n", directions, directions)
        facing = np.abs(np.einsum("nc,nc->n", hits.cross, directions)) / np.sqrt(np.maximum(square, 1e-20))
        wide = hits.far * np.float32(pixel) * self._density[hits.face] / np.sqrt(np.maximum(facing, 1e-3))
        level = (np.log2(np.maximum(wide, 1e-6)) + 0.5).astype(int).clip(0, LEVELS - 1)
        texture = mesh.texture[hits.face]
        height, width = self._size[texture, level].T
        column = np.floor(uv[:, 0] * width).astype(np.int64) % width
        row = np.floor((1.0 - uv[:, 1]) * height).astype(np.int64) % height
        found = self._texels[self._first[texture, level] + row * width + column]
        return found * mesh.tint[hits.face]


def pyramid(image: np.ndarray) -> list[np.ndarray]:
    """A picture and its halves, LEVELS in all; one that is too large is halved first."""
    while max(image.shape[:2]) > LARGEST:
        image = halved(image)
    levels = [image]
    while len(levels) < LEVELS:
        levels.append(halved(levels[-1]))
    return levels


def halved(image: np.ndarray) -> np.ndarray:
    """The picture at half the size, at least one texel, each the mean of those that it stands for."""
    rows, columns = image.shape[:2]
    if min(rows, columns) == 1 and max(rows, columns) == 1:
        return image
    even = np.pad(image, ((0, rows % 2 if rows > 1 else 1), (0, columns % 2 if columns > 1 else 1), (0, 0)), "edge")
    four = even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2, 3)
    return ((four.sum(axis=(1, 3), dtype=np.uint16) + 2) >> 2).astype(np.uint8)


def density(mesh: Mesh, size: np.ndarray) -> np.ndarray:
    """(F,) float32: texels along a metre of each triangle. size (T, 2): rows and columns of the pictures."""
    a, b, c = (mesh.uv[mesh.faces[:, corner]] for corner in range(3))
    one, other = b - a, c - a
    rows, columns = size[np.maximum(mesh.texture, 0)].T
    texels = np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) * rows * columns
    area = np.linalg.norm(mesh.crosses(), axis=1)
    return np.sqrt(texels / np.maximum(area, 1e-12)).astype(np.float32)
