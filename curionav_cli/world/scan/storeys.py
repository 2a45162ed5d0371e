"""The floors of a scan: level surfaces with something standing on them, lowest first."""

from __future__ import annotations

import math

import numpy as np

from curionav_cli.errors import SceneError
from curionav_cli.world.scan.mesh import Mesh
from curionav_cli.world.settings import Scan

BIN = 0.05  # metres of the histogram of heights
APART = 1.8  # metres between two storeys; what is nearer is a table, a step or a bed
SLAB, ALIKE = 0.6, 0.7  # metres, and share of the area: a floor has an underside, and its top is what counts
SHARE = 0.1  # of the largest level surface: a floor has at least so much
LEAST = 0.5  # square metres of the smallest floor
STANDING = 0.2  # square metres of upright surface on a floor, for each metre of its side and of agent_height
NEAR = 0.1  # metres around a peak of the histogram: of its floor


def storeys(mesh: Mesh, env: Scan) -> list[float]:
    """Heights of the floors, metres, lowest first; flipped triangles count as others."""
    cross = mesh.crosses()
    area = 0.5 * np.linalg.norm(cross, axis=1)
    flat = np.abs(cross[:, 2]) >= 2.0 * math.cos(math.radians(env.slope)) * area
    z = mesh.vertices[:, 2][mesh.faces]
    height, level_area = z[flat].mean(axis=1), area[flat]
    if not len(height):
        return []
    first = math.floor(height.min() / BIN) - 1
    held = np.bincount(np.floor(height / BIN).astype(int) - first, level_area, minlength=4)
    smooth = np.convolve(held, np.ones(3), "same")
    enough = max(LEAST, SHARE * smooth.max())
    steep = np.abs(cross[:, 2]) < area
    upright = z[steep].min(axis=1), z[steep].max(axis=1), area[steep]
    found: list[tuple[float, float]] = []  # height, area
    for at in np.flatnonzero(smooth >= enough):
        peak = at + int(np.argmax(smooth[at:at + 3]))
        level = floor_height(height, level_area, (peak + first + 0.5) * BIN)
        if not stands_on(level, smooth[peak], upright, env):
            continue
        if found and BIN < level - found[-1][0] < SLAB and smooth[peak] >= ALIKE * found[-1][1]:
            found[-1] = level, smooth[peak]
        elif not found or level - found[-1][0] >= APART:
            found.append((level, smooth[peak]))
    return [level for level, _ in found]


def floor_height(height: np.ndarray, area: np.ndarray, about: float) -> float:
    """The median height of the level surface around `about`, by area."""
    near = np.abs(height - about) <= NEAR
    order = np.argsort(height[near], kind="stable")
    grown = np.cumsum(area[near][order])
    return float(height[near][order][np.searchsorted(grown, grown[-1] / 2.0)])


def stands_on(level: float, floor: float, upright: tuple[np.ndarray, ...], env: Scan) -> bool:
    """Whether walls or furniture stand on a level surface of `floor` square metres, as not on a roof."""
    low, high, area = upright
    bottom, top = level + env.step, level + env.agent_height
    share = (np.minimum(high, top) - np.maximum(low, bottom)) / np.maximum(high - low, 1e-6)
    return float(area @ share.clip(0.0, 1.0)) >= STANDING * math.sqrt(floor) * env.agent_height


def chosen_level(mesh: Mesh, env: Scan) -> tuple[float, list[float]]:
    """The height of the floor to explore, and all floors. Raises SceneError where there is none."""
    found = storeys(mesh, env)
    if env.level is not None:
        return env.level, found
    if not found:
        raise SceneError(f"{env.mesh}: no floor was found, no level surface with something standing on it. Say which "
                         "axis points up, as env.up=z, how long a unit is, env.scale, or how high the floor is, "
                         "env.level.")
    if env.storey >= len(found):
        floors = ", ".join(f"{index}: {level:.2f} m" for index, level in enumerate(found))
        raise SceneError(f"{env.mesh}: there is no storey {env.storey}. There is {floors}. Another height: env.level.")
    return found[env.storey], found
