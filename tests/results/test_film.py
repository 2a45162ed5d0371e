"""The film of an episode, read back by another decoder's eyes: frames, colours, the robot where it was."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from curionav_cli.records import Episode, FloorPlan, Pose
from curionav_cli.results import film

STEPS = 12


@pytest.fixture
def plan(a_plan) -> FloorPlan:
    return a_plan(20, 20)


@pytest.fixture
def episode() -> Episode:
    """The camera sees red first and green later, while the robot drives from left to right."""
    image = np.zeros((STEPS + 1, 64, 64, 3), np.uint8)
    image[:6, ..., 0], image[6:, ..., 1] = 200, 200
    pose = np.column_stack([np.linspace(0.3, 1.7, STEPS + 1), np.full(STEPS + 1, 1.5), np.zeros(STEPS + 1)])
    return Episode(image, np.zeros(STEPS, np.int64), pose, np.zeros(STEPS, bool))


def read(path: Path) -> np.ndarray:
    """(N, H, W, 3) RGB."""
    capture, found = cv2.VideoCapture(str(path)), []
    while (answer := capture.read())[0]:
        found.append(answer[1][..., ::-1])
    return np.stack(found)


def test_the_film_plays_and_shows_the_episode(tmp_path: Path, plan: FloorPlan, episode: Episode,
                                              capfd: pytest.CaptureFixture[str]) -> None:
    film.write(film.frames(plan, episode, "episode 3"), tmp_path / "film.webm")
    assert capfd.readouterr().err == ""
    assert (tmp_path / "film.webm").read_bytes()[:4] == b"\x1a\x45\xdf\xa3" and not list(tmp_path.glob(".*"))
    shown = read(tmp_path / "film.webm").astype(int)
    assert shown.shape == (STEPS + 1, film.SIDE, 2 * film.SIDE, 3)
    middle = shown[:, film.SIDE // 3, film.SIDE // 2]
    assert (middle[:6, 0] > 150).all() and (middle[:6, 1] < 60).all()
    assert (middle[6:, 1] > 150).all() and (middle[6:, 0] < 60).all()
    for frame, pose in zip(shown, episode.pose, strict=True):
        orange = np.argwhere(np.abs(frame[:, film.SIDE:] - film.ROBOT).max(-1) < 60)
        across, down = orange[:, 1].mean() / film.SIDE * 2.0, 2.0 - orange[:, 0].mean() / film.SIDE * 2.0
        assert abs(across - pose[0]) < 0.12 and abs(down - pose[1]) < 0.12


def test_a_film_made_again_is_the_same_file(tmp_path: Path, plan: FloorPlan, episode: Episode) -> None:
    for name in ("one", "two"):
        film.write(film.frames(plan, episode, "episode 3"), tmp_path / f"{name}.webm")
    assert (tmp_path / "one.webm").read_bytes() == (tmp_path / "two.webm").read_bytes()


def test_the_start_is_a_blue_square(a_plan) -> None:
    plan = a_plan(20, 20)
    plan = FloorPlan(**{**vars(plan), "start": Pose(1.0, 0.5, 0.0)})
    drawn = film.PlanView(plan).drawn
    assert (drawn[film.SIDE * 3 // 4, film.SIDE // 2] == (29, 78, 216)).all()
