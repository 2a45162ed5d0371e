"""The atlas: every material, the baked floor and ceiling, as one array of packed colours with mip levels.

Packed: red + 256 green + 65536 blue in a uint32, read by one 1-D `take`. A material's level l holds
128 >> l columns of 128 texels (v runs fastest), so that a wall's texel is base + level + column * 128 + v.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

from curionav_cli.world.materials.materials import SIZE, picture

if TYPE_CHECKING:
    from curionav_cli.world.scene.scene import Scene

LEVELS = 7  # of a material
SHEET_LEVELS = 6  # of floor and ceiling
TEXEL = SIZE / 2.56  # texels a metre of a tiled material
FLOOR_TEXEL, CEILING_TEXEL = 0.025, 0.05  # metres; more where a scene is very large
FLOOR_MOST, CEILING_MOST = 4e6, 1e6  # texels
CEILING = np.array([218, 217, 212.0])
LAMP = np.array([255, 252, 236.0])
PART = 256  # rows of a sheet that are packed at once
RED_BLUE, GREEN = np.uint32(0xFF00FF), np.uint32(0x00FF00)
HAZE = (188, 192, 196)  # beyond the far plane

LEVEL_OFFSET = np.cumsum([0] + [(SIZE >> level) * SIZE for level in range(LEVELS)])


@dataclass(frozen=True)
class Sheet:
    """An image of the floor or ceiling: where each mip level starts, its rows, its texels per metre.

    Columns run along y: the texel (row, column) of a level is base + column * stride + row.
    """

    base: np.ndarray
    stride: np.ndarray
    scale: np.ndarray


@dataclass(frozen=True)
class Atlas:
    """The atlas. texels (n,) uint32; base (materials,): where each material of the scene's boxes starts."""

    texels: np.ndarray
    base: np.ndarray
    floor: Sheet
    ceiling: Sheet
    haze: int


def build_atlas(scene: Scene) -> Atlas:
    """Build all textures of a scene; moved objects do not change them."""
    blocks = [material_block(name) for name in scene.boxes.materials]
    base = np.cumsum([0] + [len(block) for block in blocks])
    floor, floor_blocks = _sheet(floor_picture(scene), _texel(scene, FLOOR_TEXEL, FLOOR_MOST), int(base[-1]))
    after = int(base[-1]) + sum(map(len, floor_blocks))
    ceiling_texel = _texel(scene, CEILING_TEXEL, CEILING_MOST)
    ceiling, ceiling_blocks = _sheet(ceiling_picture(scene), ceiling_texel, after)
    haze = np.array([HAZE[0] | HAZE[1] << 8 | HAZE[2] << 16] * SIZE, np.uint32)
    texels = np.concatenate([*blocks, *floor_blocks, *ceiling_blocks, haze])
    return Atlas(texels, base[:-1], floor, ceiling, len(texels) - SIZE)


def pack(rgb: np.ndarray) -> np.ndarray:
    """Pack (..., 3) uint8 as (...) uint32."""
    packed = rgb[..., 2].astype(np.uint32)
    for channel in (1, 0):
        packed <<= 8
        packed |= rgb[..., channel]
    return packed


def lit(texel: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Packed colours uint32 times light / 256. Overwrites texel."""
    red_blue = texel & RED_BLUE
    red_blue *= light
    red_blue >>= 8
    red_blue &= RED_BLUE
    texel &= GREEN
    texel *= light
    texel >>= 8
    texel &= GREEN
    texel |= red_blue
    return texel


def unpack(packed: np.ndarray, rgb: np.ndarray) -> None:
    """Unpack colours (B, R, C) uint32 into rgb (B, R, C, 3) uint8."""
    four, three = packed.astype("<u4", copy=False).view(np.uint8).reshape(-1, 4), rgb.reshape(-1, 3)
    for channel in range(3):  # one by one: three times as fast as four[:, :3] at once
        three[:, channel] = four[:, channel]


def material_block(name: str) -> np.ndarray:
    """The mip levels of one material, (n,) uint32, each blurred over the texels that it merges."""
    image = picture(name).astype(np.float64)
    levels = []
    for level in range(LEVELS):
        step = 1 << level
        centred = -(step // 2) if step > 1 else 0  # a kept column stands for itself and the next ones
        blurred = ndimage.uniform_filter(image, (step, step, 1), mode="wrap", origin=(0, centred, 0))
        levels.append(pack(np.rint(blurred[:, ::step]).astype(np.uint8)).T.ravel())
    return np.concatenate(levels)


def _texel(scene: Scene, finest: float, most: float) -> float:
    return max(finest, float(np.sqrt(scene.size[0] * scene.size[1] / most)))


def _sheet(image: np.ndarray, texel: float, base: int) -> tuple[Sheet, list[np.ndarray]]:
    blocks, bases, strides, scales = [], [], [], []
    for level in range(SHEET_LEVELS):
        bases.append(base)
        strides.append(image.shape[0])
        scales.append(1.0 / (texel * 2**level))
        blocks.append(_columns(image))
        base += len(blocks[-1])
        image = _halved(image)
    return Sheet(np.array(bases), np.array(strides), np.array(scales)), blocks


def _columns(image: np.ndarray) -> np.ndarray:
    """The packed texels of (rows, columns, 3) float, column by column; in parts, since a sheet may be large."""
    packed = np.empty(image.shape[:2], np.uint32)
    for at in range(0, len(image), PART):
        packed[at:at + PART] = pack(np.rint(image[at:at + PART]).astype(np.uint8))
    return packed.T.ravel()


def _halved(image: np.ndarray) -> np.ndarray:
    rows, columns = image.shape[:2]
    half = np.empty(((rows + 1) // 2, (columns + 1) // 2, 3), np.float32)
    for at in range(0, rows, PART):
        part = image[at:at + PART]
        if len(part) % 2 or columns % 2:
            part = np.pad(part, ((0, len(part) % 2), (0, columns % 2), (0, 0)), mode="edge")
        fours = part.reshape(len(part) // 2, 2, part.shape[1] // 2, 2, 3)
        half[at // 2:(at + PART) // 2] = fours.mean(axis=(1, 3), dtype=np.float32)
    return half


def _grid(scene: Scene, texel: float) -> tuple[np.ndarray, np.ndarray]:
    """y (rows, 1) and x (1, columns) of the texel centres of a sheet, one texel past the scene's edge."""
    columns, rows = (int(np.ceil(length / texel)) + 2 for length in scene.size)
    return (np.arange(rows)[:, None] + 0.5) * texel, (np.arange(columns)[None, :] + 0.5) * texel


def floor_picture(scene: Scene) -> np.ndarray:
    """The floor, (rows, columns, 3) float32: materials, rugs, and contact shadows."""
    texel = _texel(scene, FLOOR_TEXEL, FLOOR_MOST)
    y, x = _grid(scene, texel)
    ground = scene.ground
    tiles = np.stack([picture(name) for name in ground.materials])
    row = np.minimum((y / ground.cell).astype(int), ground.index.shape[0] - 1)
    column = np.minimum((x / ground.cell).astype(int), ground.index.shape[1] - 1)
    v, u = (y * TEXEL).astype(int) % SIZE, (x * TEXEL).astype(int) % SIZE
    image = np.empty((len(y), x.shape[1], 3), np.float32)
    for at in range(0, len(y), PART):
        part = slice(at, at + PART)
        image[part] = tiles[ground.index[row[part], column], v[part], u]
    for rug in ground.rugs:
        v = ((y.ravel() - rug.low[1]) / (rug.high[1] - rug.low[1]) * SIZE).astype(int)
        u = ((x.ravel() - rug.low[0]) / (rug.high[0] - rug.low[0]) * SIZE).astype(int)
        rows, columns = (np.flatnonzero((at >= 0) & (at < SIZE)) for at in (v, u))
        image[np.ix_(rows, columns)] = picture(rug.material)[np.ix_(v[rows], u[columns])]
    image *= _shadow(scene, texel, image.shape[:2])[..., None]
    return image


def _shadow(scene: Scene, texel: float, shape: tuple[int, int]) -> np.ndarray:
    """(rows, columns) in (0, 1]: darker beside walls and under furniture."""
    covered = np.zeros(shape, np.float32)
    boxes = scene.boxes
    first, last = (np.floor(corner[:, :2] / texel).astype(int).clip(0) for corner in (boxes.low, boxes.high))
    for box in np.flatnonzero(~boxes.decal & (boxes.low[:, 2] < 1.0) & (boxes.item < 0)):
        part = covered[first[box, 1]:last[box, 1] + 1, first[box, 0]:last[box, 0] + 1]
        np.maximum(part, 1.0 - 0.7 * boxes.low[box, 2], out=part)
    blurred = ndimage.gaussian_filter(covered, 0.09 / texel, mode="nearest", truncate=2.5)
    np.minimum(blurred, 1.0, out=blurred)
    blurred *= -0.55
    blurred += 1.0
    return blurred


def ceiling_picture(scene: Scene) -> np.ndarray:
    """The ceiling, (rows, columns, 3) float32: panels, and lamps with a glow around them."""
    texel = _texel(scene, CEILING_TEXEL, CEILING_MOST)
    y, x = _grid(scene, texel)
    seam = ((y % 0.6) < texel) | ((x % 0.6) < texel)
    image = (np.where(seam, 0.9, 1.0)[..., None] * CEILING).astype(np.float32)
    for lamp_x, lamp_y in scene.lamps:
        rows = slice(*np.searchsorted(y.ravel(), (lamp_y - 1.2, lamp_y + 1.2)))
        columns = slice(*np.searchsorted(x.ravel(), (lamp_x - 1.2, lamp_x + 1.2)))
        dy, dx = np.abs(y[rows] - lamp_y), np.abs(x[:, columns] - lamp_x)
        glow = 0.55 * np.exp(-((dx**2 + dy**2) / 0.5))[..., None]
        image[rows, columns] += glow * (LAMP - image[rows, columns])
        image[rows, columns][(dx < 0.3) & (dy < 0.15)] = LAMP
    return image
