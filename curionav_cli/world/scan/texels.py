"""The colours of a mesh: its pictures with halved copies as one array, and a look-up for the hits of rays."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from curionav_cli.world.render.texture_atlas import GREEN, RED_BLUE, pack
from curionav_cli.world.scan.mesh import Mesh
from curionav_cli.world.scan.tracer import Hits

NOTHING = 188 | 192 << 8 | 196 << 16  # what is seen through a hole: the haze of the other worlds
LEVELS = 8
EXPONENT, BIAS = 23, 127  # of a float32's bits


class Texels:
    """Looks up colours. texels (n,) uint32, packed: level by level, picture by picture.

    frame (F, 6) float32: u and v of the first corner, then how they change towards the second and the third; sharp
    (F,) float32: twice the texels that a triangle covers.
    """

    def __init__(self, mesh: Mesh):
        self._texture, self.textured = mesh.texture, bool(len(mesh.textures))
        self.mixed = self.textured and bool((mesh.texture < 0).any())
        if self.mixed or not self.textured:
            self._corners = pack(mesh.colour)[mesh.faces]
        if self.textured:
            self._load(mesh)

    def _load(self, mesh: Mesh) -> None:
        sides = np.array([[-(-side // 2**level) for side in image.shape[:2]] for image in mesh.textures
                          for level in range(LEVELS)])
        self._height, self._width = sides.T.astype(np.float32)
        ends = np.cumsum(sides.prod(axis=1))
        self._first, self._texels = ends - sides.prod(axis=1), np.empty(ends[-1], np.uint32)
        levels = (level for image in mesh.textures for level in pyramid(image))
        for first, end, level in zip(self._first, ends, levels, strict=True):
            self._texels[first:end] = pack(level).ravel()
        uv = mesh.uv[mesh.faces]
        uv[..., 1] = 1.0 - uv[..., 1]  # pictures begin at the top
        one, other = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
        self._frame = np.concatenate([uv[:, 0], one, other], axis=1)
        rows, columns = (side[::LEVELS][np.maximum(mesh.texture, 0)] for side in (self._height, self._width))
        self._sharp = np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]) * rows * columns

    def look_up(self, hits: Hits, directions: np.ndarray, pixel: float) -> np.ndarray:
        """(N,) uint32: the packed colours that rays meet. pixel: width of one at depth 1."""
        if not self.textured:
            found = self._plain(hits)
        elif not self.mixed:
            found = self._painted(hits, directions, pixel)
        else:
            found = self._plain(hits)
            which = np.flatnonzero(self._texture.take(hits.face, mode="wrap") >= 0)
            found[which] = self._painted(Hits(*(part[which] for part in hits)), directions[which], pixel)
        found[hits.face < 0] = NOTHING
        return found

    def _plain(self, hits: Hits) -> np.ndarray:
        """The colours of the corners, mixed in 256 steps: red and blue in one number, green in another."""
        corners = self._corners.take(hits.face, axis=0, mode="wrap")
        second, third = ((weight * np.float32(256.0)).astype(np.uint32) for weight in (hits.u, hits.v))
        first = 256 - second - third
        found = np.zeros(len(corners), np.uint32)
        for channels in (RED_BLUE, GREEN):
            part = corners & channels
            mixed = part[:, 0] * first
            mixed += part[:, 1] * second
            mixed += part[:, 2] * third
            mixed >>= 8
            mixed &= channels
            found |= mixed
        return found

    def _painted(self, hits: Hits, directions: np.ndarray, pixel: float) -> np.ndarray:
        """The colours of the pictures, as sharp as a pixel is wide."""
        frame = self._frame.take(hits.face, axis=0, mode="wrap")
        level = self._level(hits, directions, pixel)
        level += self._texture.take(hits.face, mode="wrap").astype(np.int32) * LEVELS
        place = []
        for axis, size in ((0, self._width), (1, self._height)):
            at = frame[:, axis] + hits.u * frame[:, 2 + axis] + hits.v * frame[:, 4 + axis]
            at -= np.floor(at)
            wide = size.take(level)
            place.append(np.minimum(at * wide, wide - 1.0).astype(np.int32))
        address = self._first.take(level)
        address += place[1] * self._width.take(level).astype(np.int32) + place[0]
        return self._texels.take(address, mode="clip")

    def _level(self, hits: Hits, directions: np.ndarray, pixel: float) -> np.ndarray:
        """(N,) int32: how often a picture is halved where a pixel covers several texels."""
        facing = np.abs(np.einsum("nc,nc->n", hits.cross, directions))  # twice the area, times its slant and |d|
        along = np.sqrt(np.einsum("nc,nc->n", directions, directions))
        wide = hits.far * np.float32(pixel)
        wide *= wide
        wide *= self._sharp.take(hits.face, mode="wrap") * along
        wide /= np.maximum(facing, np.float32(1e-12))
        level = (wide.view(np.int32) >> EXPONENT) - (BIAS - 1) >> 1
        return np.clip(level, 0, LEVELS - 1, out=level)


def pyramid(image: np.ndarray) -> Iterator[np.ndarray]:
    """A picture and its halves, LEVELS in all."""
    for level in range(LEVELS):
        yield image
        if level < LEVELS - 1:
            image = halved(image)


def halved(image: np.ndarray) -> np.ndarray:
    """The picture at half the size, at least one texel, each the mean of those that it stands for."""
    rows, columns = image.shape[:2]
    even = np.pad(image, ((0, rows % 2), (0, columns % 2), (0, 0)), "edge")
    four = even.reshape(even.shape[0] // 2, 2, even.shape[1] // 2, 2, 3)
    return ((four.sum(axis=(1, 3), dtype=np.uint16) + 2) >> 2).astype(np.uint8)
