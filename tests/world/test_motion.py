"""Perfect motion: against a march of tiny steps, and what must never happen."""

from __future__ import annotations

import numpy as np
import pytest

from curionav_cli.constants import HEADINGS, STEP_LENGTH
from curionav_cli.geometry import rectangle_distance
from curionav_cli.world.motion import COLLISIONS, COS, SIN, _share, forward, forward_clear, free_share


def test_the_circle_is_exact_at_the_quarters_and_symmetric() -> None:
    assert COS[[0, 9, 18, 27]].tolist() == [1.0, 0.0, -1.0, 0.0]
    assert SIN[[0, 9, 18, 27]].tolist() == [0.0, 1.0, 0.0, -1.0]
    heading = np.arange(HEADINGS)
    assert np.array_equal(COS, SIN[(heading + 9) % 36])
    assert np.array_equal(SIN[-heading % 36], -SIN)
    assert np.array_equal(COS[(18 - heading) % 36], -COS)
    assert np.allclose(COS, np.cos(heading * np.pi / 18), atol=1e-15)


def march(visitable: np.ndarray, cell: float, x: float, y: float, heading: int) -> bool:
    """Is every point of the move, at 20 micrometres, on a visitable cell?"""
    share = np.linspace(0.0, 1.0, 12_501)
    row = np.floor((y + share * STEP_LENGTH * SIN[heading]) / cell).astype(int)
    column = np.floor((x + share * STEP_LENGTH * COS[heading]) / cell).astype(int)
    inside = (row >= 0) & (row < visitable.shape[0]) & (column >= 0) & (column < visitable.shape[1])
    return bool(inside.all()) and bool(visitable[row, column].all())


@pytest.mark.parametrize("cell", [0.05, 0.07, 0.1, 0.25, 0.6])
def test_a_move_is_clear_where_a_march_of_tiny_steps_is(cell: float) -> None:
    rng = np.random.default_rng(3)
    visitable = rng.random((14, 17)) < 0.85
    row, column = (at[rng.integers(0, visitable.sum(), 400)] for at in np.nonzero(visitable))
    x, y = (column + rng.random(400)) * cell, (row + rng.random(400)) * cell
    heading = rng.integers(0, 36, 400)
    clear = forward_clear(visitable, cell, x, y, heading)
    marched = np.array([march(visitable, cell, *pose) for pose in zip(x, y, heading, strict=True)])
    differs = clear != marched
    assert differs.sum() <= 2  # a corner cut by less than the march's step
    assert not (clear & ~marched).any()
    assert clear.any() and not clear.all()


def test_one_move_agrees_with_many(small_room, draw_spots) -> None:
    plan = small_room.plan
    x, y, heading = draw_spots(small_room, 500, 0)
    many = forward_clear(plan.visitable, plan.cell, x, y, heading)
    ones = [not forward(plan.visitable, plan.cell, *pose)[2] for pose in zip(x, y, heading, strict=True)]
    assert many.tolist() == ones


def test_a_cancelled_move_is_bit_identical() -> None:
    visitable = np.ones((3, 3), bool)
    x, y = 0.29 + 1e-17, 0.1 / 3
    assert forward(visitable, 0.1, x, y, 0) == (x, y, True)


def test_stop_ends_at_the_obstacle_and_slide_goes_on_along_it() -> None:
    visitable = np.ones((10, 10), bool)
    visitable[:, 5:] = False
    x, y, hit = forward(visitable, 0.1, 0.4, 0.2, 4, "stop")
    assert hit and 0.4999 < x < 0.5
    assert y - 0.2 == pytest.approx((x - 0.4) * np.tan(np.radians(40)), abs=1e-9)
    slid_x, slid_y, hit = forward(visitable, 0.1, 0.4, 0.2, 4, "slide")
    assert hit and slid_x < 0.5
    assert slid_y == pytest.approx(0.2 + STEP_LENGTH * SIN[4], abs=1e-6)


@pytest.mark.parametrize("mode", COLLISIONS)
def test_random_walks_stay_on_the_mask_and_clear_of_everything(small_room, mode: str) -> None:
    plan, boxes = small_room.plan, small_room.boxes
    rng = np.random.default_rng(1)
    x, y, heading, xs, ys = plan.start.x, plan.start.y, 9, [], []
    for turn, goes in zip(rng.integers(-2, 3, 4000), rng.random(4000) < 0.7, strict=True):
        heading = (heading + int(turn)) % HEADINGS
        if goes:
            x, y, _ = forward(plan.visitable, plan.cell, x, y, heading, mode)
        xs.append(x)
        ys.append(y)
    rows, columns = plan.cells(np.array(xs), np.array(ys))
    assert plan.visitable[rows, columns].all()
    least = plan.radius - plan.cell * np.sqrt(0.5)
    for box in np.flatnonzero(boxes.solid(small_room.agent_height)):
        away = rectangle_distance(np.array(xs), np.array(ys), boxes.low[box, :2], boxes.high[box, :2])
        assert away.min() > least


def test_a_quarter_million_steps_of_many_robots_stay_clear(small_room, draw_spots) -> None:
    plan, boxes = small_room.plan, small_room.boxes
    x, y, heading = draw_spots(small_room, 4096, 5)
    rng = np.random.default_rng(2)
    solid = boxes.solid(small_room.agent_height)
    low, high = boxes.low[solid, :2], boxes.high[solid, :2]
    for _ in range(64):
        heading = (heading + rng.integers(-3, 4, len(x))) % HEADINGS
        goes = forward_clear(plan.visitable, plan.cell, x, y, heading)
        x, y = x + goes * STEP_LENGTH * COS[heading], y + goes * STEP_LENGTH * SIN[heading]
        assert plan.visitable[plan.cells(x, y)].all()
    nearest = min(rectangle_distance(x, y, *box).min() for box in zip(low, high, strict=True))
    assert nearest > plan.radius - plan.cell * np.sqrt(0.5)


def test_free_share_is_where_the_first_blocked_cell_begins() -> None:
    visitable = np.ones((1, 10), bool)
    visitable[0, 4] = False
    one = np.ones(1)
    share = free_share(visitable, 0.1, 0.25 * one, 0.05 * one, 0.25 * one, 0.0 * one)
    assert share[0] == pytest.approx(0.6)


@pytest.mark.parametrize("cell", [0.05, 0.1, 0.3])
def test_one_move_is_the_move_of_a_batch_to_the_bit(cell: float) -> None:
    """The scalar path against the arrays, also on lines and corners of the grid, along axes, in short moves."""
    rng = np.random.default_rng(0)
    visitable = rng.random((40, 50)) < 0.8
    x, y = rng.random(2000) * 50 * cell, rng.random(2000) * 40 * cell
    x[:500], y[250:750] = np.round(x[:500] / cell) * cell, np.round(y[250:750] / cell * 2) / 2 * cell
    heading, part = rng.integers(0, HEADINGS, 2000), rng.random(2000) ** np.tile([0, 2], 1000)
    dx, dy = STEP_LENGTH * COS[heading] * part, STEP_LENGTH * SIN[heading] * part
    batch = free_share(visitable, cell, x, y, dx, dy)
    single = [_share(visitable, cell, *move) for move in zip(*(a.tolist() for a in (x, y, dx, dy)), strict=True)]
    assert np.array_equal(np.array(single), batch)
    assert 0.2 < np.mean(batch == 1.0) < 0.8
