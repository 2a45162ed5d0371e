"""Where in its cell a return lay decides which cells are too near; changes are followed without counting anew."""

from __future__ import annotations

import numpy as np

from curionav_cli.agents.mapper.clearance import Clearance


def counted(clearance: Clearance, occupied: np.ndarray) -> np.ndarray:
    """The count by its definition: every cell against every return."""
    rows, columns = np.nonzero(occupied)
    at = np.stack([rows, columns], 1) + clearance.point[rows, columns]  # (n, 2)
    grid = np.stack(np.indices(occupied.shape), -1)  # (rows, columns, 2)
    away = np.hypot(*np.moveaxis(grid[:, :, None] - at, -1, 0))
    return (away <= clearance.limit).sum(-1)


def test_a_wall_at_the_near_side_of_its_cell_closes_more_than_one_at_the_far_side() -> None:
    for offset, closed in ((-0.45, [2, 3]), (0.45, [3])):
        clearance = Clearance((1, 6), 0.1, 0.16)
        clearance.note(np.array([0]), np.array([4]), np.array([[0.0, offset]]))
        occupied = np.arange(6)[None] == 4
        clearance.follow(occupied)
        assert [column for column in range(4) if clearance.count[0, column]] == closed


def test_changes_are_followed_as_if_counted_anew() -> None:
    rng = np.random.default_rng(0)
    clearance = Clearance((12, 15), 0.1, 0.23)
    for _ in range(30):
        row, column = rng.integers(0, 12, 9), rng.integers(0, 15, 9)
        clearance.note(row, column, rng.uniform(-0.5, 0.5, (9, 2)))
        occupied = rng.random((12, 15)) < 0.2
        near = clearance.follow(occupied)
        np.testing.assert_array_equal(clearance.count, counted(clearance, occupied))
        assert (clearance.count.flat[near] > 0).all()


def test_it_grows_with_what_it_holds() -> None:
    clearance = Clearance((4, 4), 0.1, 0.1)
    occupied = np.zeros((4, 4), bool)
    occupied[1, 2] = True
    clearance.follow(occupied)
    clearance.grow((3, 2), (9, 8))
    larger = np.zeros((9, 8), bool)
    larger[4, 4] = True
    assert not len(clearance.follow(larger)), "nothing changed"
    np.testing.assert_array_equal(clearance.count, counted(clearance, larger))
