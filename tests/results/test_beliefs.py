"""True and estimated paths of a run, and the error of the estimate in its metrics."""

from dataclasses import replace

import numpy as np
import pytest

from curionav_cli.execution.recorder import estimate_error
from curionav_cli.results import beliefs
from curionav_cli.results.floor_plans import meanings
from curionav_cli.results.runs import Run, dock_returns
from curionav_cli.storage.run_folder import RunFolder

SETTINGS = "env: {name: lab}\nagent: {name: bounce}\nrobot: {name: turtlebot2i}\nseed: 3\nscale: cpu\n"


@pytest.fixture
def robots_run(tmp_path, an_episode, a_plan):
    """Three episodes of a robot whose estimate is 0.3 m too far east; it was carried to the dock before the third."""
    folder = RunFolder(tmp_path)
    folder.create(SETTINGS, {}, {}, a_plan())
    for index, dock in enumerate([None, {"code": "docked", "human": False, "attempts": 2},
                                  {"code": "dock_not_seen", "human": True, "attempts": 3}]):
        plain = an_episode(seed=index)
        folder.save_episode(index, replace(plain, estimate=plain.pose + [0.3, 0.0, 0.1], dock=dock))
    return Run(folder)


def test_each_episode_has_a_panel_with_both_paths_and_how_the_robot_returned(robots_run):
    figure = beliefs.paths(robots_run)
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == ["0: first start", "1: docked, attempt 2", "2: dock_not_seen, carried"]
    drawn = {line.get_label(): line.get_xdata() for line in figure.axes[0].lines}
    assert drawn["estimated path"] == pytest.approx(drawn["true path"] + 0.3)


def test_the_paths_of_an_ideal_robot_are_not_drawn(tmp_path, an_episode, a_plan):
    folder = RunFolder(tmp_path)
    folder.create(SETTINGS, {}, {}, a_plan())
    folder.save_episode(0, an_episode())
    assert beliefs.paths(Run(folder)) is None


def test_metrics_hold_the_error_of_the_estimate_and_how_the_robot_returned(an_episode):
    plain = an_episode()
    robot = replace(plain, estimate=plain.pose + [0.3, 0.4, 2 * np.pi - 0.1], dock={"human": True})
    assert estimate_error(plain) == {}
    assert estimate_error(robot) == pytest.approx({"position_error": 0.5, "yaw_error": np.degrees(0.1), "docked": False,
                                           "carried": True})
    rows = [{}, estimate_error(robot), estimate_error(replace(robot, dock={"human": False}))]
    assert dock_returns(rows) == {"docked": 1, "carried": 1} and dock_returns([{}]) == {}


def test_of_a_real_robot_the_estimate_alone_is_drawn_and_has_no_error(tmp_path, an_episode, a_plan):
    folder = RunFolder(tmp_path)
    folder.create(SETTINGS, {}, {}, replace(a_plan(), bounded=False))
    live = replace(an_episode(), estimate=an_episode().pose, dock={"human": False, "attempts": 1})
    folder.save_episode(0, live)
    figure = beliefs.paths(Run(folder))
    labels = [line.get_label() for line in figure.axes[0].lines]
    assert "estimated path" in labels and "true path" not in labels and "true" not in figure.get_suptitle()
    assert "can be reached" not in {str(one.get_label()) for one in meanings(figure.axes[0], Run(folder).plan)}
    assert estimate_error(live) == {"docked": True, "carried": False}
