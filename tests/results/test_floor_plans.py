"""The plan as a map: every kind of cell has its colour, walls are never lost, axes are those of the map."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from curionav_cli.records import ORIGIN, FloorPlan, Pose
from curionav_cli.results import floor_plans, lettering, plots
from curionav_cli.results.coverage import Coverage
from curionav_cli.results.floor_plans import FLOOR, KINDS, PART, PART_SOLID, REACHED, SOLID, UNKNOWN


@pytest.fixture
def a_map():
    """a_map(rows, columns): known and free but for a wall around it, unknown beyond; the robot keeps a cell away."""
    def make(rows: int = 20, columns: int = 30, cell: float = 0.05, origin: Pose = ORIGIN) -> FloorPlan:
        occupancy = np.full((rows, columns), -1, np.int8)
        occupancy[2:-2, 2:-2], occupancy[3:-3, 3:-3] = 100, 0
        visitable = np.zeros((rows, columns), bool)
        visitable[4:-4, 4:-4] = True
        return FloorPlan(visitable, occupancy == 0, occupancy == 100, cell, Pose(6 * cell, 6 * cell, 0.0), 0.05, "map",
                         origin, occupancy)
    return make


def test_each_cell_is_drawn_as_what_it_is(a_map) -> None:
    plan = a_map()
    plan.occupancy[10, 10:12] = 40, 60
    plan.solid[10, 11], plan.visitable[10, 10:12] = True, False
    kinds = floor_plans.kinds(plan)
    assert kinds[0, 0] == UNKNOWN and kinds[2, 5] == SOLID and kinds[3, 3] == FLOOR and kinds[5, 5] == REACHED
    assert kinds[10, 10:12].tolist() == [PART, PART_SOLID]
    assert len({kind.color for kind in KINDS}) == len(KINDS)
    figure = floor_plans.sheet(plan, "a map")
    shown = [text.get_text() for text in figure.legends[0].get_texts()]
    assert shown == ["start and dock", *(KINDS[number].name for number in (SOLID, PART_SOLID, PART, REACHED, FLOOR,
                                                                          UNKNOWN))]


def test_a_wall_of_one_cell_is_in_every_picture_of_a_large_building(a_map) -> None:
    plan = a_map(300, 500)
    plan.solid[:, 222] = True
    grid = floor_plans.squares(floor_plans.kinds(plan), 7)
    assert (grid[:, 222 // 7] == SOLID).all() and grid.shape == (43, 72)
    axes = plots.heatmap(Coverage(plan), "large").axes[0]
    ground, _, walls = (image.get_array() for image in axes.images)
    assert max(ground.shape) <= floor_plans.SQUARES
    dark = (ground == to_rgba(KINDS[SOLID].color)).all(-1)
    assert (dark.mean(0) > 0.9).sum() == 3  # left and right, and the wall within
    np.testing.assert_array_equal(walls[..., 3] == 1.0, dark)


def test_a_visited_square_does_not_hide_a_wall(a_map) -> None:
    """Visits to a large building are drawn on squares of many cells, below its walls."""
    axes = plots.heatmap(Coverage(a_map(600, 600)), "large").axes[0]
    plan, visits, walls = axes.images
    assert plan.get_zorder() < visits.get_zorder() < walls.get_zorder()


@pytest.mark.parametrize("yaw", [0.0, 0.7, np.pi / 2])
def test_axes_are_those_of_the_map_turned_by_the_origins_yaw(a_map, yaw: float) -> None:
    plan = replace(a_map(cell=0.5, origin=Pose(-3.0, 2.0, yaw)), dock=Pose(5.0, 5.0, 1.0))
    axes = floor_plans.sheet(plan, "turned").axes[0]
    marks = {line.get_label(): (line.get_xdata()[0], line.get_ydata()[0]) for line in axes.lines}
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    for name, pose in (("start", plan.start), ("dock", plan.dock)):
        assert marks[name] == pytest.approx(turn @ pose[:2] + [-3.0, 2.0])
    corners = turn @ [[0.5, 14.5, 0.5, 14.5], [0.5, 0.5, 9.5, 9.5]] + [[-3.0], [2.0]]  # a margin of two cells
    assert axes.get_xlim() == pytest.approx((corners[0].min(), corners[0].max()))
    assert axes.get_ylim()[1] == pytest.approx(corners[1].max())
    image = axes.images[0]
    middle = (image.get_transform() - axes.transData).transform((3.0, 3.0))
    assert middle == pytest.approx(marks["start"]), "the picture is turned with its marks"


@pytest.mark.parametrize(("rows", "columns", "cell", "metres"), [
    (40, 60, 0.05, 0.5), (120, 200, 0.5, 20.0), (9, 400, 0.5, 50.0), (400, 9, 0.25, 1.0)])
def test_the_scale_bar_is_a_round_length_that_fits(a_map, rows: int, columns: int, cell: float, metres: float) -> None:
    plan = a_map(rows, columns, cell)
    axes = floor_plans.sheet(plan, "title").axes[0]
    bar = axes.artists[0]
    assert bar.txt_label.get_text() == f"{metres:g} m"
    assert bar.size_bar.get_children()[0].get_width() == metres < 0.85 * floor_plans.size_of(plan)[0]


@pytest.mark.parametrize(("rows", "columns"), [(9, 400), (340, 9), (40, 60)])
def test_nothing_runs_out_of_the_picture_or_over_another(a_map, rows: int, columns: int) -> None:
    plan = a_map(rows, columns)
    for figure in (floor_plans.sheet(plan, "a name of a building " * 9),
                   plots.heatmap(Coverage(plan), "a_name_without_a_space" * 9)):
        figure.draw_without_rendering()
        whole = figure.bbox
        title, legend = figure._suptitle.get_window_extent(), figure.legends[0].get_window_extent()
        inside = [axes.get_tightbbox() for axes in figure.axes]
        for box in (title, legend, *inside):
            assert min(box.x0, box.y0) >= -1 and box.x1 <= whole.x1 + 1 and box.y1 <= whole.y1 + 1
        for box in inside:
            assert legend.y1 <= box.y0 + 1 and box.y1 <= title.y0 + 1


def test_what_the_font_cannot_draw_is_written_out_and_dollars_are_no_formula(tmp_path: Path, a_map) -> None:
    assert lettering.legible("Büro 3 地図\n\udcff") == "Büro 3 \\u5730\\u56f3\n\\udcff"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        figure = plots.heatmap(Coverage(a_map()), "地図 of a$b$c_d")
        plots.save(figure, tmp_path / "a.png")
    assert figure._suptitle.get_text() == "\\u5730\\u56f3 of a$b$c_d"


def test_lines_break_where_they_must() -> None:
    assert lettering.wrapped("one two\nthree", 3.0) == "one two\nthree"
    assert max(map(len, lettering.wrapped("x" * 100, 2.0).split("\n"))) == int(2.0 / lettering.LETTER)
