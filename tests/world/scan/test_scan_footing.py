"""Ramps, stairs, tilts and noise: where a robot on wheels may go in a scan, by step and slope."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from meshmaking import box, quad, room, write_ply

from curionav_cli.world.scan.upright import levelling
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain

pytest.importorskip("trimesh", reason="the extra scan is not installed")
pytest.importorskip("embreex", reason="the extra scan is not installed")

HALL = room(width=6.0)


def cells(folder: Path, triangles: np.ndarray, **settings) -> np.ndarray:
    """Visitable cells by row and column, the robot's start in the hall's left half."""
    path = write_ply(folder / "hall.ply", triangles)
    raw, source = plain("scan", mesh=str(path), cell=0.1, **{"start": [1.55, 1.55, 0], **settings})
    return Scene.from_dict(raw, source).plan.visitable


def ramp(rise: float) -> np.ndarray:
    """From x 2.5 to 3.5 m, the hall's whole depth, up by `rise`; beyond it a level stage at that height."""
    return np.concatenate([quad((2.5, 0, 0), (1, 0, rise), (0, 3, 0)), quad((3.5, 0, rise), (2.5, 0, 0), (0, 3, 0))])


def test_a_low_ramp_is_driven_and_a_higher_one_ends_the_floor(tmp_path: Path) -> None:
    whole = cells(tmp_path, HALL).sum()
    assert cells(tmp_path, np.concatenate([HALL, ramp(0.028)])).sum() == whole
    high = cells(tmp_path, np.concatenate([HALL, ramp(0.3)]))
    assert 0.3 * whole < high.sum() < 0.5 * whole
    assert cells(tmp_path, np.concatenate([HALL, ramp(0.3)]), step=0.29).sum() > high.sum()


def test_stairs_end_the_floor_at_their_first_step(tmp_path: Path) -> None:
    stairs = [box((3.0 + 0.3 * at, 0, 0), (3.3 + 0.3 * at, 3, 0.17 * (at + 1))) for at in range(6)]
    free = cells(tmp_path, np.concatenate([HALL, *stairs]))
    columns = np.flatnonzero(free.any(axis=0))
    assert columns[-1] - columns[0] + 1 == 28  # from 0.1 to 2.9 m, a radius before the wall and before the first step
    one = cells(tmp_path, np.concatenate([HALL, *stairs]), step=0.2)
    assert one.sum() > free.sum()  # the first is a kerb then, and the second ends the floor
    assert np.flatnonzero(one.any(axis=0))[-1] - columns[-1] == 3


@pytest.mark.parametrize("degrees", [1, 5, 12])
def test_a_scanner_held_askew_costs_next_to_nothing(tmp_path: Path, degrees: int) -> None:
    angle = np.radians(degrees)
    turned = HALL @ levelling(np.array([np.sin(angle) * 0.6, np.sin(angle) * 0.8, np.cos(angle)]))
    whole = cells(tmp_path, HALL, start=None).sum()
    assert abs(int(cells(tmp_path, turned, start=None).sum()) / int(whole) - 1) < 0.05


def test_noise_that_tilts_every_triangle_makes_no_holes(tmp_path: Path) -> None:
    """4 mm of noise on triangles of 2 cm: a quarter of them is steeper than 30 degrees of nothing but noise."""
    fine = quad((0, 0, 0), (2, 0, 0), (0, 2, 0), 100)
    height = np.random.default_rng(0).normal(0.0, 0.006, (101, 101))
    corner = np.rint(fine[..., :2] / 0.02).astype(int)
    fine[..., 2] = height[corner[..., 0], corner[..., 1]]
    walls = [quad((0, 0, 0), (2, 0, 0), (0, 0, 2)), quad((0, 2, 0), (2, 0, 0), (0, 0, 2)),
             quad((0, 0, 0), (0, 2, 0), (0, 0, 2)), quad((2, 0, 0), (0, 2, 0), (0, 0, 2))]
    assert cells(tmp_path, np.concatenate([fine, *walls]), start=None).sum() == 18 * 18
