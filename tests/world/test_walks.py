"""A building's probe: the same for every run, on visitable cells, moved as the robot moves."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from curionav_cli.constants import FORWARD, LEFT, RIGHT, STEP_LENGTH, TURN_ANGLE
from curionav_cli.decisions import EACH_STEP, Steps
from curionav_cli.options import Options
from curionav_cli.probe import CONTEXT, Probe
from curionav_cli.world import walks
from curionav_cli.world.env import NavigationEnv
from curionav_cli.world.scene.scene import Scene
from curionav_cli.world.scene.scene_file import plain


@pytest.fixture(scope="module")
def room() -> Scene:
    return Scene.from_dict(*plain("small_room"))


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(walks, "SEQUENCES", 12)


def test_the_same_scene_gives_the_same_bytes(room: Scene, few: None, tmp_path: Path) -> None:
    for name in "ab":
        walks.draw(room).save(tmp_path / name)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    first, again = walks.draw(room), Probe.load(tmp_path / "a")
    assert again.checksum == first.checksum and again.every == 1
    np.testing.assert_array_equal(again.pose, first.pose)
    assert first.image.shape == (12, 17, 64, 64, 3) and first.action.shape == (12, 16)


def test_starts_are_spread_evenly_over_the_visitable_cells(room: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    cells = int(room.plan.visitable.sum())
    monkeypatch.setattr(walks, "SEQUENCES", 50 * cells)
    x, y, heading = walks.starts(room, np.random.default_rng(0))
    row, column = room.plan.cells(np.array(x), np.array(y))
    assert room.plan.visitable[row, column].all()
    visits = np.bincount(row * room.plan.visitable.shape[1] + column, minlength=room.plan.visitable.size)
    visits = visits[room.plan.visitable.ravel()]
    assert 0.85 < ((visits - 50) ** 2 / 50).mean() < 1.15  # a chi square for each cell: 1
    assert np.bincount(heading, minlength=36).min() > 0.8 * len(x) / 36


def test_frames_are_free_until_a_move_is_blocked(room: Scene, few: None) -> None:
    """Counted again frame by frame, with the actions held for two steps; of options all frames are free."""
    for every in (EACH_STEP, Steps(2)):
        probe = walks.draw(room, every)
        for pose, action, free in zip(probe.pose, probe.action, probe.free):
            blocked = [step for step in range(CONTEXT - 1, 16) if action[step] == FORWARD
                       and np.linalg.norm(pose[step + 1, :2] - pose[step, :2]) < every.held * STEP_LENGTH - 1e-6]
            assert free.sum() == (blocked[0] + 1 if blocked else 17) - CONTEXT and sorted(free, reverse=True) == [*free]
        assert not probe.free.all() and probe.free.any()
    assert walks.draw(room, Options()).free.all()


def test_a_sequence_moves_as_the_robot_does_and_sees_what_it_sees(room: Scene, few: None) -> None:
    probe, env = walks.draw(room), NavigationEnv(room)
    step, turn = np.diff(probe.pose[..., :2], axis=1), np.diff(probe.pose[..., 2], axis=1)
    moved, forward = np.hypot(*step.transpose(2, 0, 1)), probe.action == FORWARD
    assert set(np.round(moved[forward], 9)) == {0.0, STEP_LENGTH} and not moved[~forward].any()
    for action, angle in ((LEFT, TURN_ANGLE), (RIGHT, -TURN_ANGLE), (FORWARD, 0.0)):
        np.testing.assert_allclose(np.cos(turn[probe.action == action] - angle), 1.0, atol=1e-12)
    row, column = room.plan.cells(probe.pose[..., 0], probe.pose[..., 1])
    assert room.plan.visitable[row, column].all()
    env.reset(seed=0)
    seen = env.look(*probe.pose[3].T)["image"]
    assert (np.abs(seen.astype(int) - probe.image[3]) > 2).mean() < 0.01  # the yaw in radians, not in tens of degrees


def test_held_actions_show_the_frames_that_an_agent_acts_on(room: Scene) -> None:
    whole = walks.walk(room, (0.55, 0.45, 9), np.repeat([0, 1, 0, 2], 4).tolist(), EACH_STEP)
    held = walks.walk(room, (0.55, 0.45, 9), [0, 1, 0, 2], Steps(4))
    for every_step, kept in zip(whole, held):
        np.testing.assert_array_equal(every_step[::4], kept)


def test_options_turn_and_drive_until_something_is_in_the_way(room: Scene, few: None) -> None:
    _, y, heading = walks.walk(room, (0.55, 0.45, 9), [0, 3], Options())
    assert (heading[1] - heading[0], (heading[2] - heading[1]) % 36) == (0, 6)
    assert y[1] - y[0] == pytest.approx(8 * STEP_LENGTH)  # the room goes on for two metres
    probe = walks.draw(room, Options())
    assert probe.every == 0 and set(np.unique(probe.action)) <= set(range(7)) and len(np.unique(probe.action)) > 3


def test_actions_are_repeated_more_often_than_not() -> None:
    action = walks.decisions(3, walks.REPEAT, np.random.default_rng(0))
    assert (action[:, 1:] == action[:, :-1]).mean() == pytest.approx(0.75 + 0.25 / 3, abs=0.02)


def test_a_changing_building_is_probed_as_its_first_episode_is_arranged(few: None) -> None:
    lab = Scene.from_dict(*plain("large_lab"))
    now, _ = lab.at(0, 0)
    probe = walks.draw(lab)
    row, column = now.plan.cells(probe.pose[..., 0], probe.pose[..., 1])
    assert now.plan.visitable[row, column].all() and (now.plan.visitable != lab.plan.visitable).any()
    env = NavigationEnv(lab)
    env.reset(seed=0, options={"episode": 0})
    seen = env.look(*probe.pose[0].T)["image"]
    assert (np.abs(seen.astype(int) - probe.image[0]) > 2).mean() < 0.01
