"""Coverage against counting by hand."""

import numpy as np
import pytest

from curionav_cli.results.coverage import RULES, Coverage, Curve, cover


def walk(*points):
    return np.array([[x, y, 0.0] for x, y in points])


def test_landing_counts_the_cells_where_steps_end(a_plan):
    plan = a_plan(rows=4, columns=6, cell=0.1)
    coverage = Coverage(plan)
    assert coverage.add(walk((0.15, 0.15), (0.35, 0.15), (0.35, 0.15), (0.15, 0.15))) == 2
    assert coverage.visits[1].tolist() == [0, 2, 0, 2, 0, 0] and coverage.visited == 2 and coverage.steps == 3
    coverage.add(walk((0.15, 0.15), (0.15, 0.25)))
    assert coverage.curve().found.tolist() == [0, 1, 4]
    assert coverage.share == pytest.approx(3 / coverage.total)


def test_a_cell_reaches_up_to_its_border_and_no_further(a_plan):
    plan = a_plan(rows=4, columns=6, cell=0.05)
    coverage = Coverage(plan)
    coverage.add(walk((0.0999, 0.0999), (0.1001, 0.0999), (0.0999, 0.1001)))
    assert np.argwhere(coverage.visits).tolist() == [[1, 1], [1, 2], [2, 1]]


def test_swept_adds_the_cells_between_and_footprint_those_under_the_robot(a_plan):
    plan = a_plan(rows=4, columns=6, cell=0.1, radius=0.11)
    pose = walk((0.15, 0.15), (0.35, 0.15))
    cells = {rule: {divmod(int(cell), 6) for cell in RULES[rule](plan, pose)[1]} for rule in RULES}
    assert cells["landing"] == {(1, 1), (1, 3)}
    assert cells["swept"] == {(1, 1), (1, 2), (1, 3)}
    assert cells["footprint"] == {(1, 0), (1, 1), (1, 2), (0, 1), (2, 1), (1, 3), (1, 4), (0, 3), (2, 3)}


@pytest.mark.parametrize("rule", RULES)
def test_coverage_never_passes_one_and_only_grows(a_plan, rule):
    plan = a_plan(rows=12, columns=9, cell=0.1, hole=True)
    rng = np.random.default_rng(0)
    poses = [np.column_stack([rng.uniform(0, 0.9, 300), rng.uniform(0, 1.2, 300), np.zeros(300)]) for _ in range(9)]
    coverage = cover(plan, poses, rule)
    assert coverage.visited == coverage.total and coverage.share == 1.0
    curve = coverage.curve()
    assert len(curve.found) == coverage.total and (np.diff(curve.found) >= 0).all()
    assert coverage.total == plan.visitable.sum() and not coverage.visits[~plan.visitable].any()


def test_the_floor_is_the_other_denominator(a_plan):
    plan = a_plan(rows=12, columns=9, cell=0.1, hole=True)
    assert Coverage(plan, denominator="floor").total == plan.floor.sum() > plan.visitable.sum()


def test_area_and_steps_to_a_share():
    curve = Curve(found=np.array([0, 2, 4, 8]), steps=10, total=5)
    by_hand = np.mean([np.sum(curve.found <= step) / 5 for step in range(10)])
    assert curve.area() == pytest.approx(by_hand)
    assert [curve.steps_to(share) for share in (0.2, 0.5, 0.8, 0.9, 0.99)] == [0, 4, 8, None, None]
    assert curve.at(np.array([0, 1, 2, 10])).tolist() == [1, 1, 2, 4]
    assert Curve(np.array([], np.int64), 0, 5).area() == 0.0


def test_swept_is_what_a_walk_in_steps_of_a_tenth_of_a_millimetre_finds(a_plan):
    plan = a_plan(rows=60, columns=60, cell=0.05)
    rng = np.random.default_rng(0)
    pose = np.column_stack([rng.uniform(0.3, 2.7, 60), rng.uniform(0.3, 2.7, 60), np.zeros(60)])
    pose[10] = pose[9]
    pose[11, 0], pose[12, 1] = pose[10, 0], pose[11, 1]  # along the axes
    walked = set()
    for start, end in zip(pose[:-1, :2], pose[1:, :2], strict=True):
        points = np.linspace(start, end, 30001)
        row, column = plan.cells(points[:, 0], points[:, 1])
        walked |= set((row * 60 + column).tolist())
    found = set(RULES["swept"](plan, pose)[1].tolist())
    assert walked <= found and len(found - walked) <= 2  # a corner may be cut by less than a step


def test_a_robot_that_only_turned_swept_the_cell_where_it_stood(a_plan) -> None:
    plan = a_plan(rows=6, columns=6, cell=0.1)
    pose = np.tile([0.35, 0.25, 0.0], (4, 1))
    pose[:, 2] = np.arange(4)
    assert cover(plan, [pose], "swept").visited == 1
