"""Surprise on the map: where it is ascribed to, how it fades, what a place is worth, which way pays most."""

from __future__ import annotations

import math

import numpy as np
import pytest

from curionav_cli.agents.curious_mapper.foraging import best_way, within_reach
from curionav_cli.agents.curious_mapper.levels import Levels
from curionav_cli.agents.curious_mapper.memory import SurpriseMemory
from curionav_cli.agents.lattice import Lattice
from curionav_cli.constants import FORWARD
from curionav_cli.records import Pose
from curionav_cli.robot.measurements import Scan

BEARING = np.linspace(-0.6, 0.6, 64)
HERE, FAR_AWAY = Pose(0.05, 0.05, 0.0), Pose(0.05, 0.05, math.pi)


def memory(cell: float = 0.1) -> SurpriseMemory:
    """A memory in its second episode."""
    made = SurpriseMemory(cell, reach=4.0, radius=0.15, sight=1.5, optimism=0.9)
    made.number = 2
    return made


def wall_at(metres: float) -> Scan:
    return Scan(BEARING, np.full(64, metres), 0.0)


def view(made: SurpriseMemory, surprise: float, pose: Pose = HERE, metres: float = 1.0) -> None:
    """A step that ends at a pose whose image shows a wall at a distance."""
    made.see(pose, wall_at(metres), 0.0)
    made.levels.add(surprise)
    made.measured = surprise
    made.land(pose.x, pose.y, pose[:2])


def at(made: SurpriseMemory, grid: np.ndarray, x: float, y: float = 0.05):
    return grid[made.map.cells(x, y)]


def test_a_view_is_ascribed_to_what_it_shows_and_to_where_it_was_taken() -> None:
    made = memory()
    view(made, 3.0)
    for x, shown in ((0.05, True), (0.65, True), (1.05, True), (1.35, False), (-0.35, False)):
        assert bool(at(made, made.shown, x)) is shown, x
        assert at(made, made.surprise, x) == (3.0 if shown else 0.0)


def test_no_measurement_changes_nothing() -> None:
    made = memory()
    made.see(HERE, wall_at(1.0), 0.0)
    made.land(0.05, 0.05, (0.05, 0.05))
    assert not made.shown.any() and at(made, made.visited, 0.05)


def test_the_mean_of_a_few_views_then_the_newest_count_more() -> None:
    made = memory()
    for surprise in (2.0, 4.0, 6.0):
        view(made, surprise)
    assert at(made, made.surprise, 0.65) == pytest.approx(4.0)
    for _ in range(60):
        view(made, 1.0)
    assert at(made, made.surprise, 0.65) < 1.1


def test_what_an_untrained_model_measured_is_forgotten() -> None:
    made = memory()
    made.number = 1
    view(made, 9.0)
    made.begin()
    assert not made.shown.any() and not len(made.levels.recent) and made.number == 2
    view(made, 2.0)
    assert at(made, made.surprise, 0.65) == 2.0 and made.levels.usual == 2.0


def test_what_moved_is_worth_a_visit_again() -> None:
    """Two corners are known, one duller than the other; then the dull one surprises, and is worth most."""
    made = memory()
    for _ in range(12):
        for _ in range(3):
            view(made, 1.0)
            view(made, 2.0, FAR_AWAY)
        made.begin()
    made.visited[:] = True
    made.levels.recent[:] = 2.0
    assert made.levels.trust > 0.9
    assert made.worth_of_surprise().max() < 1e-3
    for _ in range(4):
        view(made, 6.0)
    worth = made.worth_of_surprise()
    assert at(made, worth, 0.65) > 1.0 and at(made, worth, -0.55) < 1e-3
    assert at(made, worth, 0.05) == 0.0, "a place pays once an episode"


def test_a_new_place_is_worth_what_first_sights_were() -> None:
    made = memory()
    for _ in range(100):
        made.levels.add(2.0)
    made.levels.first = np.linspace(1.0, 3.0, 101, dtype=np.float32)
    assert made.levels.expected == pytest.approx(2.0 * 2.8)
    worth = made.worth_of_surprise()
    assert worth.min() == worth.max() == pytest.approx(2.0 * 1.8)


def test_surprise_that_falls_everywhere_as_the_model_learns_says_nothing_of_places() -> None:
    """Remembered and measured fall together over ten episodes, and within each have nothing in common."""
    rng, levels = np.random.default_rng(0), Levels(0.9)
    seen = []
    for level in range(10, 0, -1):
        for remembered, measured in rng.normal(level, 0.1, (50, 2)):
            levels.met_again(remembered, measured)
            seen.append((remembered, measured))
        levels.end_of_episode()
    assert np.polyfit(*np.array(seen).T, 1)[0] > 0.95, "over all episodes they seem to agree"
    assert levels.trust < 0.1


def test_a_map_whose_differences_are_not_found_again_makes_no_difference() -> None:
    rng = np.random.default_rng(0)
    true, idle = memory(), memory()
    for made in (true, idle):
        view(made, 2.0)
        for remembered in rng.uniform(1.0, 9.0, 500):
            made.levels.met_again(remembered, remembered if made is true else 9.0 - remembered)
        made.levels.first = np.full(10, 4.0, np.float32)
    assert (true.levels.trust, idle.levels.trust, Levels(0.9).trust) == (pytest.approx(1.0), 0.0, 0.0)
    for made, less in ((true, True), (idle, False)):
        worth = made.worth_of_surprise()
        assert bool(at(made, worth, 0.65) < at(made, worth, -1.0)) is less, "seen from elsewhere, and dull"


def test_episodes_learn_how_much_surprise_is_left() -> None:
    """The model learns: what gave 4 nats gives 1 the next day, and after some days the memory says so at once."""
    made = memory()
    for _ in range(12):
        view(made, 4.0)
        made.begin()
        view(made, 1.0)
        made.begin()
    assert made.levels.fade < 1.0
    left = Levels(0.9)
    for _ in range(12):
        left.met_again(4.0 * left.fade, 1.0)
        left.end_of_episode()
    assert left.fade == pytest.approx(0.25, abs=0.01)


def test_it_grows_and_goes_on_from_what_it_saved() -> None:
    made = memory()
    view(made, 3.0)
    view(made, 2.0, Pose(7.0, 0.0, 0.0))
    assert at(made, made.surprise, 0.65) == 3.0 and made.surprise.dtype == np.float32
    other = memory()
    other.load({name: value.copy() for name, value in made.save().items()})
    assert made.save().keys() == {*SurpriseMemory.SAVED, *SurpriseMemory.LATER}
    for each in (made, other):
        each.begin()
        view(each, 1.5, Pose(7.5, 0.0, 1.0))
    for name, value in made.save().items():
        np.testing.assert_array_equal(value, other.save()[name], name)


def test_the_way_with_most_for_an_action() -> None:
    """A small worth ahead, a larger one behind: the larger pays where the way matters little."""
    worth = np.zeros((20, 40), np.float32)
    worth[10, 25], worth[10, 5] = 1.0, 3.0
    lattice = Lattice(np.ones((20, 40), bool), worth > 0, 0.1)
    near, far = (best_way(lattice, 2.05, 1.05, 0, worth, stay) for stay in (0.0, 100.0))
    assert set(near) == {FORWARD} and len(near) == 2
    assert len(far) > 18 and far.count(FORWARD) >= 5
    assert best_way(lattice, 2.05, 1.05, 0, 0 * worth, 5.0) == []


def test_what_lies_behind_a_wall_is_out_of_reach() -> None:
    free, known = np.ones((10, 20), bool), np.zeros((10, 20), bool)
    free[:, 10], known[:, 2:10] = False, True
    reach = within_reach(free, known, 5, 0, near=5)
    assert reach[:, :10].all() and not reach[:, 10:].any()
