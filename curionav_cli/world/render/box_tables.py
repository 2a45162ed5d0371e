"""Tables that the engines read for each box: z slabs and texture addresses, by image row.

Rows of every table: the closed boxes (floor to ceiling, nothing is visible over or under them), the open
ones, then FAR_BOX (the haze behind everything), EMPTY (never hit) and PLANE (floor and ceiling).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from curionav_cli.world.materials.materials import SIZE
from curionav_cli.world.render.texture_atlas import LEVEL_OFFSET, LEVELS, SHEET_LEVELS, TEXEL, Atlas
from curionav_cli.world.scene.boxes import EAST, NORTH, SOUTH, WEST, Boxes

FACE_LIGHT = np.array([0.90, 0.82, 0.97, 0.86])  # west, east, south, north
TOP_LIGHT, UNDER_LIGHT, FLOOR_LIGHT, CEILING_LIGHT = 1.0, 0.5, 0.94, 0.97
HAZE = 0.035  # light left at depth d: 1 / (1 + HAZE d)
STRETCH = SIZE - 0.02  # texels of a fitted picture; the rest keeps rounding inside it
NOWHERE = 1e9


@dataclass(frozen=True)
class BoxTables:
    """K boxes and three more rows; R image rows. Flat tables are indexed by box * R + row or box * 4 + face."""

    walls: int  # how many boxes are closed
    bounds: np.ndarray  # (2, 2, K + 3) float64: low and high, x and y, box
    near: np.ndarray  # (K + 3, R) float32: depth at which row r enters the box's heights
    far: np.ndarray
    heights: np.ndarray  # (2, K + 3) float32: bottom and top above the camera; 0 of the three more rows
    address: np.ndarray  # flat int32: texel of the horizontal face that row r meets
    stride: np.ndarray
    x_scale: np.ndarray  # flat float32, texels a metre
    x_shift: np.ndarray
    y_scale: np.ndarray
    y_shift: np.ndarray
    light: np.ndarray  # flat float32, 0 to 256
    side_base: np.ndarray  # flat int32, index box * 4 + face
    side_along: np.ndarray  # flat float32: texels a metre along the wall, negative where it runs backwards
    side_shift: np.ndarray
    side_up: np.ndarray  # texels a metre upwards, and the texel at the camera's height
    side_foot: np.ndarray
    side_mip: np.ndarray  # twice the texels that a pixel covers one metre away, face on
    side_light: np.ndarray

    @property
    def boxes(self) -> int:
        """K, the number of boxes."""
        return len(self.near) - 3


def build_box_tables(boxes: Boxes, atlas: Atlas, height: float, camera: float, slope: np.ndarray,
                     pixel: float) -> BoxTables:
    """Build the tables. slope (R,): rise of each row's rays per metre of depth; pixel: width of one at depth 1."""
    closed = (boxes.low[:, 2] <= 0.0) & (boxes.high[:, 2] >= height) & ~boxes.decal
    boxes = _ordered(boxes, np.argsort(~closed, kind="stable"))
    near, far = _heights(boxes, height, camera, slope)
    blank = np.full((2, 2, 3), NOWHERE)
    return BoxTables(
        walls=int(closed.sum()),
        bounds=np.concatenate([np.stack([boxes.low[:, :2].T, boxes.high[:, :2].T]), blank], axis=2),
        near=near, far=far, heights=_above(boxes, camera), **_horizontal(boxes, atlas, near, slope, pixel),
        **_vertical(boxes, atlas, camera, pixel))


def _ordered(boxes: Boxes, order: np.ndarray) -> Boxes:
    columns = (field.name for field in fields(boxes) if field.name != "materials")
    return replace(boxes, **{name: getattr(boxes, name)[order] for name in columns})


def _heights(boxes: Boxes, height: float, camera: float, slope: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    down = (boxes.low[:, 2, None] - camera) / slope
    up = (boxes.high[:, 2, None] - camera) / slope
    plane = np.where(slope < 0, -camera, height - camera) / slope
    near = np.concatenate([np.minimum(down, up), np.zeros((2, len(slope))), plane[None]])
    far = np.concatenate([np.maximum(down, up), np.full((3, len(slope)), np.inf)])
    return np.maximum(near, 0.0).astype(np.float32), far.astype(np.float32)


def _above(boxes: Boxes, camera: float) -> np.ndarray:
    both = np.stack([boxes.low[:, 2], boxes.high[:, 2]]) - camera
    return np.concatenate([both, np.zeros((2, 3))], axis=1).astype(np.float32)


def _horizontal(boxes: Boxes, atlas: Atlas, near: np.ndarray, slope: np.ndarray,
                pixel: float) -> dict[str, np.ndarray]:
    """Tops are fitted pictures, or tiles at their true size; undersides are their material, dark."""
    low, extent = boxes.low[:, :2], boxes.high[:, :2] - boxes.low[:, :2]
    full = np.where(boxes.fit[:, None], STRETCH / extent, np.minimum(TEXEL, STRETCH / extent))
    wide = np.maximum(full[:, :1], full[:, 1:]) * near[:len(boxes)] * pixel / np.sqrt(np.abs(slope))
    level = np.clip(np.log2(np.maximum(wide, 1e-6)) + 0.5, 0, LEVELS - 1).astype(int)
    shrink = 0.5 ** level
    x_scale, y_scale = full[:, :1] * shrink, np.broadcast_to(full[:, 1:], level.shape)
    tops = {
        "address": atlas.base[boxes.top][:, None] + LEVEL_OFFSET[level],
        "stride": np.full(level.shape, SIZE), "x_scale": x_scale, "y_scale": y_scale,
        "x_shift": -low[:, :1] * x_scale, "y_shift": -low[:, 1:] * y_scale,
        "light": np.broadcast_to(np.where(slope < 0, TOP_LIGHT, UNDER_LIGHT), level.shape),
    }
    plane = _plane(atlas, near[-1], slope, pixel)
    light = 256.0 / (1.0 + HAZE * near)
    kinds = {"address": np.int32, "stride": np.int32}
    flat = {}
    for key, table in tops.items():
        rows = np.concatenate([table, np.zeros((2, len(slope))), plane[key][None]])
        flat[key] = (rows * light if key == "light" else rows).astype(kinds.get(key, np.float32)).ravel()
    return flat


def _plane(atlas: Atlas, depth: np.ndarray, slope: np.ndarray, pixel: float) -> dict[str, np.ndarray]:
    """Floor and ceiling, as rows of the tables in _horizontal."""
    down = slope < 0
    finest = np.where(down, atlas.floor.scale[0], atlas.ceiling.scale[0])
    texels = depth * pixel * finest / np.sqrt(np.abs(slope))
    level = np.clip(np.log2(np.maximum(texels, 1e-6)) + 0.3, 0, SHEET_LEVELS - 1).astype(int)
    base, stride, scale = (
        np.where(down, getattr(atlas.floor, key)[level], getattr(atlas.ceiling, key)[level])
        for key in ("base", "stride", "scale"))
    none = np.zeros(len(slope))
    return {"address": base, "stride": stride, "x_scale": scale, "y_scale": scale, "x_shift": none,
            "y_shift": none, "light": np.where(down, FLOOR_LIGHT, CEILING_LIGHT)}


def _vertical(boxes: Boxes, atlas: Atlas, camera: float, pixel: float) -> dict[str, np.ndarray]:
    """u runs to the viewer's right on every face, v upwards."""
    count = len(boxes)
    along, shift = np.zeros((count + 3, 4)), np.zeros((count + 3, 4))
    up, foot = np.zeros((count + 3, 4)), np.zeros((count + 3, 4))
    base, light = np.full((count + 3, 4), atlas.haze), np.full((count + 3, 4), 256.0)
    for face, axis, sign in ((WEST, 1, -1.0), (EAST, 1, 1.0), (SOUTH, 0, 1.0), (NORTH, 0, -1.0)):
        low, high = boxes.low[:, axis], boxes.high[:, axis]
        scale = np.where(boxes.fit, STRETCH / (high - low), TEXEL)
        along[:count, face] = sign * scale
        start = np.where(sign > 0, low, high)
        shift[:count, face] = np.where(boxes.fit, -sign * start * scale, 0.0)
        base[:count, face] = atlas.base[boxes.sides[:, face]]
        light[:count, face] *= FACE_LIGHT[face]
    bottom, top = boxes.low[:, 2:], boxes.high[:, 2:]
    up[:count] = np.where(boxes.fit[:, None], STRETCH / (top - bottom), TEXEL)
    foot[:count] = np.where(boxes.fit[:, None], -bottom * up[:count], 0.0)
    tables = {"side_along": along, "side_shift": shift, "side_up": up, "side_foot": foot + camera * up,
              "side_mip": 2.0 * pixel**2 * np.abs(along) * up, "side_light": light}
    flat = {key: table.astype(np.float32).ravel() for key, table in tables.items()}
    return {"side_base": base.astype(np.int32).ravel(), **flat}
