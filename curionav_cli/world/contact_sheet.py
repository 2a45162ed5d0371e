"""Overview images of a scene: the plan from above beside first-person views and their depth.

No environment needs this module.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from scipy import ndimage

from curionav_cli.constants import IMAGE_SIDE
from curionav_cli.records import FloorPlan
from curionav_cli.world.materials.materials import picture
from curionav_cli.world.motion import COS, SIN
from curionav_cli.world.render.renderer import FAR, Renderer
from curionav_cli.world.render.texture_atlas import floor_picture
from curionav_cli.world.scene.scene import Scene

ROWS, COLUMNS, SCALE, GAP = 4, 6, 2, 6
JPEG_QUALITY = 82  # for paths that end in .jpg: a fifth of the bytes of a PNG
DOOR, AIR = 1.8, 0.25  # metres: walls that begin higher are lintels; free space around a viewpoint
PAPER, INK, SHADE = (250, 249, 246), (40, 42, 46), (214, 60, 48)
MIST = (180, 194, 211)  # unknown cells of a map


def contact_sheet(scene: Scene, path: Path | str) -> None:
    """Write a PNG or JPG: the top view, and first-person views with their depth from places spread over it."""
    renderer = Renderer(scene)
    views = _spots(scene, renderer, ROWS // 2 * COLUMNS)
    rgb, depth = renderer.render(*views)
    tile = IMAGE_SIDE * SCALE + GAP
    grid = np.full((ROWS * tile + GAP, COLUMNS * tile + GAP, 3), PAPER, np.uint8)
    for index in range(len(rgb)):
        row, column = divmod(index, COLUMNS)
        for below, image in ((0, rgb[index]), (1, _depth_colours(depth[index]))):
            at = slice(GAP + (2 * row + below) * tile, GAP + (2 * row + below) * tile + IMAGE_SIDE * SCALE)
            across = slice(GAP + column * tile, GAP + column * tile + IMAGE_SIDE * SCALE)
            grid[at, across] = np.kron(image, np.ones((SCALE, SCALE, 1), np.uint8))
    plan = top_view(scene, len(grid), views)
    _write(path, np.concatenate([plan, grid], axis=1))


def plans(scenes: Sequence[Scene], path: Path | str, height: int = 420) -> None:
    """Write a PNG or JPG: top views of several scenes in a row, name and area below each. height: pixels of a view."""
    columns = []
    for scene in scenes:
        view = top_view(scene, height)
        area = scene.plan.visitable.sum() * scene.plan.cell**2
        caption = np.full((34, view.shape[1], 3), PAPER, np.uint8)
        cv2.putText(caption, f"{scene.name}: {area:.2f} m2", (GAP, 23), cv2.FONT_HERSHEY_SIMPLEX, 0.55, INK, 1,
                    cv2.LINE_AA)
        columns.append(np.concatenate([view, caption]))
    _write(path, np.concatenate(columns, axis=1))


def _write(path: Path | str, image: np.ndarray) -> None:
    quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if Path(path).suffix == ".jpg" else []
    cv2.imwrite(str(path), image[..., ::-1], quality)


def top_view(scene: Scene, height: int, views: tuple[np.ndarray, ...] = ()) -> np.ndarray:
    """A scene from above, (height, any, 3) uint8: floor, boxes by height, `views` (x, y, heading) as arrows."""
    image, texel, low = _crop(scene, _from_above(scene))
    scale = min(height / image.shape[0], 3.0 * height / image.shape[1])
    width = max(1, round(image.shape[1] * scale))
    drawn = cv2.resize(image, (width, max(1, round(image.shape[0] * scale))), interpolation=cv2.INTER_AREA)
    drawn = drawn[::-1].copy()
    for x, y, heading in zip(*views, strict=True) if views else ():
        px, py = (x - low[0]) / texel * scale, drawn.shape[0] - (y - low[1]) / texel * scale
        tip = (int(px + 14 * COS[heading]), int(py - 14 * SIN[heading]))
        cv2.arrowedLine(drawn, (int(px), int(py)), tip, SHADE, 2, cv2.LINE_AA, tipLength=0.4)
    paper = np.full((height, width + 2 * GAP, 3), PAPER, np.uint8)
    first = (height - drawn.shape[0]) // 2
    paper[first:first + drawn.shape[0], GAP:GAP + width] = drawn[:height]
    return paper


def _from_above(scene: Scene) -> tuple[np.ndarray, float]:
    if scene.plan.picture is not None:
        return scene.plan.picture.astype(np.float32), scene.size[0] / scene.plan.picture.shape[1]
    image = floor_picture(scene)
    texel = scene.size[0] / (image.shape[1] - 2)
    row, column = (np.minimum((np.arange(n) * texel / scene.plan.cell).astype(int), most - 1)
                   for n, most in zip(image.shape[:2], scene.plan.floor.shape))
    image[~scene.plan.floor[np.ix_(row, column)]] = INK
    unknown = scene.plan.unknown[np.ix_(row, column)]
    image[unknown] = MIST
    boxes = scene.boxes
    closed = boxes.high[:, 2] >= scene.height
    lintel = closed & (boxes.low[:, 2] >= DOOR)
    for box in np.lexsort((boxes.high[:, 2], closed)):
        if boxes.decal[box] or lintel[box]:
            continue
        corners = np.stack([boxes.low[box, :2], boxes.high[box, :2]])
        (c0, c1), (r0, r1) = np.rint(corners / texel).astype(int).clip(0).T
        part = image[r0:r1, c0:c1]
        if closed[box]:  # one of a map may stand for cells of the unknown, too
            part[~unknown[r0:r1, c0:c1]] = INK
        else:
            part[:] = _top(picture(boxes.materials[boxes.top[box]]), part.shape[:2])
    return image, texel


def _top(material: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """A material stretched over (rows, columns), its edges dark."""
    row, column = (np.arange(n) * len(material) // max(n, 1) for n in shape)
    image = material[np.ix_(row, column)] * 0.92
    for edge in (image[:1], image[-1:], image[:, :1], image[:, -1:]):
        edge *= 0.6
    return image


def _crop(scene: Scene, drawn: tuple[np.ndarray, float]) -> tuple[np.ndarray, float, tuple[float, float]]:
    image, texel = drawn
    rows, columns = np.nonzero(scene.plan.floor)
    margin = 0.3
    low = (columns.min() * scene.plan.cell - margin, rows.min() * scene.plan.cell - margin)
    high = ((columns.max() + 1) * scene.plan.cell + margin, (rows.max() + 1) * scene.plan.cell + margin)
    border = int(np.ceil(margin / texel))
    padded = np.pad(image, ((border, border), (border, border), (0, 0)), constant_values=INK[0])
    c0, r0 = (round(side / texel) + border for side in low)
    c1, r1 = (round(side / texel) + border for side in high)
    return padded[r0:r1, c0:c1].clip(0, 255).astype(np.uint8), texel, low


def _spots(scene: Scene, renderer: Renderer, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Poses (x, y, heading), (count,) each, spread over the visitable cells, facing much depth and contrast."""
    plan = scene.plan
    rows, columns = np.nonzero(_roomy(plan))
    x, y = (columns + 0.5) * plan.cell, (rows + 0.5) * plan.cell
    chosen = [int(np.argmin(np.hypot(x - plan.start.x, y - plan.start.y)))]
    away = np.full(len(x), np.inf)
    while len(chosen) < count:
        away = np.minimum(away, np.hypot(x - x[chosen[-1]], y - y[chosen[-1]]))
        chosen.append(int(away.argmax()))
    headings = np.arange(0, 36, 3)
    rgb, depth = renderer.render(np.repeat(x[chosen], 12), np.repeat(y[chosen], 12), np.tile(headings, count))
    near, far = depth.min(axis=(1, 2)), depth.mean(axis=(1, 2))
    worth = np.sqrt(far) * rgb.std(axis=(1, 2)).mean(axis=1) * (near > 0.3)
    return x[chosen], y[chosen], headings[worth.reshape(count, 12).argmax(axis=1)]


def _roomy(plan: FloorPlan) -> np.ndarray:
    """The visitable cells with free space around them; all of them in a scene without such."""
    away = ndimage.distance_transform_edt(np.pad(plan.visitable, 1))[1:-1, 1:-1] * plan.cell
    return (away > AIR) if (away > AIR).sum() > 50 else plan.visitable


def _depth_colours(depth: np.ndarray) -> np.ndarray:
    """(64, 64, 3) uint8: near is bright."""
    near = np.rint(255.0 * (1.0 - np.minimum(depth / FAR, 1.0) ** 0.6)).astype(np.uint8)
    return cv2.applyColorMap(near, cv2.COLORMAP_INFERNO)[..., ::-1]
